// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/search/body_surface.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

namespace nav::registration {
namespace {

constexpr double kCellMm = 5;
// Halfway between air and fat.
constexpr double kAirBelowHu = -500;
// Sigma of the smoothing. A smoothed plane tells the distance up to 2.5 sigmas.
constexpr double kSmoothMm = 8;

/// Distance from a plane for a given fraction of a Gaussian about a point that lies behind the
/// plane.
class PlaneDistance {
 public:
  PlaneDistance() {
    double x = -kReach;
    for (std::size_t i = 0; i < table_.size(); ++i) {
      const double share = static_cast<double>(i) / (kEntries - 1);
      while (x < kReach && 0.5 * std::erfc(-x / std::sqrt(2.0)) < share) x += kStep;
      table_[i] = static_cast<float>(kSmoothMm * x);
    }
  }
  [[nodiscard]] float of(float share) const {
    const auto entry = std::lround(std::clamp(share, 0.0f, 1.0f) * (kEntries - 1));
    return table_[static_cast<std::size_t>(entry)];
  }

 private:
  static constexpr double kReach = BodySurface::kReachMm / kSmoothMm;
  static constexpr double kStep = 1e-3;
  static constexpr int kEntries = 2049;
  std::array<float, kEntries> table_{};
};

void smooth(std::vector<float>& values, const std::array<int, 3>& size,
            const Eigen::Vector3d& cell_mm) {
  const auto kernel = [&](int axis) -> cv::Mat {
    // An axis with one cell has no neighbours. The cell may be thin, and a kernel in its units
    // would be long; where there are more cells they are about kCellMm long.
    if (size[static_cast<std::size_t>(axis)] == 1) return cv::Mat::ones(1, 1, CV_32F);
    const double sigma = std::max(kSmoothMm / cell_mm[axis], 1e-3);
    return cv::getGaussianKernel(2 * static_cast<int>(std::ceil(3 * sigma)) + 1, sigma, CV_32F);
  };
  const auto slice = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
  for (int k = 0; k < size[2]; ++k) {
    cv::Mat image(size[1], size[0], CV_32F, &values[static_cast<std::size_t>(k) * slice]);
    cv::sepFilter2D(image, image, CV_32F, kernel(0), kernel(1), cv::Point(-1, -1), 0,
                    cv::BORDER_REPLICATE);
  }
  // Treated as an image whose rows are whole slices, k runs down the rows.
  cv::Mat column(size[2], size[0] * size[1], CV_32F, values.data());
  cv::sepFilter2D(column, column, CV_32F, cv::Mat::ones(1, 1, CV_32F), kernel(2), cv::Point(-1, -1),
                  0, cv::BORDER_REPLICATE);
}

/// Mean HU of each cell.
std::vector<float> cell_means(const Volume& ct, const std::array<int, 3>& block,
                              const std::array<int, 3>& size) {
  const auto& n = ct.grid().size;
  std::vector<float> means(static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
                               static_cast<std::size_t>(size[2]),
                           0.0f);
  const auto hu = ct.hu();
  const float part = 1.0f / static_cast<float>(block[0] * block[1] * block[2]);
  for (int k = 0; k < size[2] * block[2]; ++k) {
    for (int j = 0; j < size[1] * block[1]; ++j) {
      const std::size_t row = (static_cast<std::size_t>(k) * static_cast<std::size_t>(n[1]) +
                               static_cast<std::size_t>(j)) *
                              static_cast<std::size_t>(n[0]);
      float* out =
          &means[(static_cast<std::size_t>(k / block[2]) * static_cast<std::size_t>(size[1]) +
                  static_cast<std::size_t>(j / block[1])) *
                 static_cast<std::size_t>(size[0])];
      for (int i = 0; i < size[0] * block[0]; ++i) {
        out[i / block[0]] += part * static_cast<float>(hu[row + static_cast<std::size_t>(i)]);
      }
    }
  }
  return means;
}

/// The grid axis along which patients are longest: the CT ends within the body there.
int long_axis(const VoxelGrid& grid) {
  int axis = 0;
  grid.directions.row(2).cwiseAbs().maxCoeff(&axis);
  return axis;
}

}  // namespace

BodySurface::BodySurface(const Volume& ct) : directions_(ct.grid().directions) {
  const VoxelGrid& grid = ct.grid();
  std::array<int, 3> block{};
  Eigen::Vector3d first;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const int wanted = static_cast<int>(std::lround(kCellMm / grid.spacing_mm[axis]));
    block[a] = std::clamp(wanted, 1, grid.size[a]);
    size_[a] = grid.size[a] / block[a];
    cell_mm_[axis] = grid.spacing_mm[axis] * block[a];
    first[axis] = 0.5 * (block[a] - 1);
  }
  origin_ct_mm_ = grid.at(first).mm;
  const std::vector<float> hu = cell_means(ct, block, size_);
  body_.assign(hu.size(), 1);
  const int along = long_axis(grid);
  // Air spreads from the sides, but not from the ends, where lungs and bowel may be cut.
  std::vector<std::array<int, 3>> front;
  const auto visit = [&](const std::array<int, 3>& cell) {
    const std::size_t at = index(cell[0], cell[1], cell[2]);
    if (body_[at] == 0 || !(hu[at] < kAirBelowHu)) return;
    body_[at] = 0;
    front.push_back(cell);
  };
  for (int k = 0; k < size_[2]; ++k) {
    for (int j = 0; j < size_[1]; ++j) {
      for (int i = 0; i < size_[0]; ++i) {
        const std::array<int, 3> cell{i, j, k};
        for (int axis = 0; axis < 3; ++axis) {
          const auto a = static_cast<std::size_t>(axis);
          if (axis != along && (cell[a] == 0 || cell[a] == size_[a] - 1)) visit(cell);
        }
      }
    }
  }
  while (!front.empty()) {
    const std::array<int, 3> cell = front.back();
    front.pop_back();
    for (std::size_t a = 0; a < 3; ++a) {
      for (const int step : {-1, 1}) {
        std::array<int, 3> next = cell;
        next[a] += step;
        if (next[a] >= 0 && next[a] < size_[a]) visit(next);
      }
    }
  }
  depth_.assign(body_.begin(), body_.end());
  smooth(depth_, size_, cell_mm_);
  const PlaneDistance distance;
  for (float& value : depth_) value = distance.of(value);
}

Eigen::Vector3d BodySurface::centre_of(int i, int j, int k) const {
  return origin_ct_mm_ + directions_ * Eigen::Vector3d(i, j, k).cwiseProduct(cell_mm_);
}

double BodySurface::depth_mm(const Point<frames::Ct>& p) const {
  const Eigen::Vector3d x =
      (directions_.transpose() * (p.mm - origin_ct_mm_)).cwiseQuotient(cell_mm_);
  std::array<int, 3> base{};
  std::array<double, 3> w{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double held = std::clamp(x[static_cast<Eigen::Index>(a)], 0.0, size_[a] - 1.0);
    base[a] = std::clamp(static_cast<int>(held), 0, std::max(size_[a] - 2, 0));
    w[a] = held - base[a];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    std::array<int, 3> at = base;
    double weight = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      const bool up = (corner >> a & 1) != 0;
      if (up) at[a] = std::min(at[a] + 1, size_[a] - 1);
      weight *= up ? w[a] : 1 - w[a];
    }
    sum += weight * depth_[index(at[0], at[1], at[2])];
  }
  return sum;
}

std::vector<SkinPoint> BodySurface::points(double spacing_mm) const {
  std::map<std::array<int, 3>, std::pair<Eigen::Vector3d, int>> cubes;
  for (int k = 0; k < size_[2]; ++k) {
    for (int j = 0; j < size_[1]; ++j) {
      for (int i = 0; i < size_[0]; ++i) {
        if (body_[index(i, j, k)] == 0) continue;
        const bool skin = (i > 0 && body_[index(i - 1, j, k)] == 0) ||
                          (i + 1 < size_[0] && body_[index(i + 1, j, k)] == 0) ||
                          (j > 0 && body_[index(i, j - 1, k)] == 0) ||
                          (j + 1 < size_[1] && body_[index(i, j + 1, k)] == 0) ||
                          (k > 0 && body_[index(i, j, k - 1)] == 0) ||
                          (k + 1 < size_[2] && body_[index(i, j, k + 1)] == 0);
        if (!skin) continue;
        const Eigen::Vector3d p = centre_of(i, j, k);
        const Eigen::Array3d cell = (p / spacing_mm).array().floor();
        auto& [sum, count] = cubes[{static_cast<int>(cell[0]), static_cast<int>(cell[1]),
                                    static_cast<int>(cell[2])}];
        if (count == 0) sum.setZero();
        sum += p;
        ++count;
      }
    }
  }
  std::vector<SkinPoint> out;
  for (const auto& [key, cube] : cubes) {
    Eigen::Vector3d p = cube.first / cube.second;
    Eigen::Vector3d slope;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = kCellMm * Eigen::Vector3d::Unit(axis);
      slope[axis] = depth_mm({p + step}) - depth_mm({p - step});
    }
    if (!(slope.norm() > 1e-3)) continue;
    slope.normalize();
    p -= depth_mm({p}) * slope;
    out.push_back({{p}, slope});
  }
  return out;
}

}  // namespace nav::registration
