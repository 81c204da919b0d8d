// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/spline_field.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "nav/check.hpp"

namespace nav::registration {
namespace {

/// The four cubic B-splines that are not zero at position t of a cell, and their slopes.
struct Four {
  std::array<double, 4> value, slope;
};
Four cubic(double t) {
  const double s = 1 - t;
  return {{s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6,
           t * t * t / 6},
          {-0.5 * s * s, 0.5 * (3 * t * t - 4 * t), -0.5 * (3 * s * s - 4 * s), 0.5 * t * t}};
}

/// Integrals of products of two cubic B-splines n cells apart, and of their first and second
/// derivatives, for a cell size of 1.
constexpr std::array<std::array<double, 4>, 3> kProducts = {
    {{2416.0 / 5040, 1191.0 / 5040, 120.0 / 5040, 1.0 / 5040},
     {2.0 / 3, -1.0 / 8, -1.0 / 5, -1.0 / 120},
     {8.0 / 3, -3.0 / 2, 0.0, 1.0 / 6}}};

}  // namespace

double SplineField::control_points_over(const CtBox& box, double spacing_mm) {
  const Eigen::Array3d cells = ((box.high - box.low) / spacing_mm).array().ceil();
  return cells.allFinite() ? (cells.max(1) + 3).prod() : std::numeric_limits<double>::infinity();
}

SplineField::SplineField(const CtBox& box, double spacing_mm) : box_(box), spacing_mm_(spacing_mm) {
  NAV_CHECK(spacing_mm > 0 && box.low.allFinite() && box.high.allFinite(), spacing_mm);
  NAV_CHECK(((box.high - box.low).array() >= 0).all(), spacing_mm);
  NAV_CHECK(control_points_over(box, spacing_mm) <= kMostControlPoints, spacing_mm);
  origin_ = box.low - Eigen::Vector3d::Constant(spacing_mm);
  for (int axis = 0; axis < 3; ++axis) {
    const double cells = std::ceil((box.high[axis] - box.low[axis]) / spacing_mm);
    size_[static_cast<std::size_t>(axis)] = std::max(1, static_cast<int>(cells)) + 3;
  }
  coefficients_ = Eigen::VectorXd::Zero(3 * control_points());
}

/// The control points that affect a point, axis by axis: the range [begin, end) of the four whose
/// first is `first`; none outside the box.
struct SplineField::Near {
  std::array<Four, 3> weights;
  std::array<int, 3> first;
  std::array<std::size_t, 3> begin, end;
};

std::optional<SplineField::Near> SplineField::near(const Eigen::Vector3d& p) const {
  Near out;
  for (int axis = 0; axis < 3; ++axis) {
    const auto n = static_cast<std::size_t>(axis);
    const double at = (p[axis] - origin_[axis]) / spacing_mm_;
    // No control point affects distant points; the cast below must not overflow.
    if (!(at > -1 && at < size_[n] + 1)) return {};
    const double cell = std::floor(at);
    out.first[n] = static_cast<int>(cell) - 1;
    out.begin[n] = static_cast<std::size_t>(std::max(0, -out.first[n]));
    out.end[n] = static_cast<std::size_t>(std::clamp(size_[n] - out.first[n], 0, 4));
    out.weights[n] = cubic(at - cell);
  }
  return out;
}

int SplineField::index(const Near& at, std::size_t a, std::size_t b, std::size_t c) const {
  const int i = at.first[0] + static_cast<int>(a);
  const int j = at.first[1] + static_cast<int>(b);
  const int k = at.first[2] + static_cast<int>(c);
  return i + size_[0] * (j + size_[1] * k);
}

SplineField::Reach SplineField::reach(const Eigen::Vector3d& p) const {
  Reach out;
  const auto at = near(p);
  if (!at) return out;
  const auto& [wx, wy, wz] = at->weights;
  for (std::size_t c = at->begin[2]; c < at->end[2]; ++c) {
    for (std::size_t b = at->begin[1]; b < at->end[1]; ++b) {
      for (std::size_t a = at->begin[0]; a < at->end[0]; ++a) {
        const auto n = static_cast<std::size_t>(out.count++);
        const double x = wx.value[a], y = wy.value[b], z = wz.value[c];
        out.index[n] = index(*at, a, b, c);
        out.weight[n] = x * y * z;
        out.slope[n] =
            Eigen::Vector3d(wx.slope[a] * y * z, x * wy.slope[b] * z, x * y * wz.slope[c]) /
            spacing_mm_;
      }
    }
  }
  return out;
}

Eigen::Vector3d SplineField::displacement(const Eigen::Vector3d& p) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto at = near(p);
  if (!at) return sum;
  // A deformed CT evaluates the field at every voxel: no weight is multiplied twice and no slope is
  // computed.
  for (std::size_t c = at->begin[2]; c < at->end[2]; ++c) {
    Eigen::Vector3d slice = Eigen::Vector3d::Zero();
    for (std::size_t b = at->begin[1]; b < at->end[1]; ++b) {
      Eigen::Vector3d row = Eigen::Vector3d::Zero();
      for (std::size_t a = at->begin[0]; a < at->end[0]; ++a) {
        row += at->weights[0].value[a] * coefficients_.segment<3>(3 * index(*at, a, b, c));
      }
      slice += at->weights[1].value[b] * row;
    }
    sum += at->weights[2].value[c] * slice;
  }
  return sum;
}

SplineField::Row SplineField::row(double y_ct_mm, double z_ct_mm) const {
  constexpr std::size_t kEnds = 2;
  Row out;
  const auto at = near({origin_.x(), y_ct_mm, z_ct_mm});
  if (!at) return out;
  out.origin_mm_ = origin_.x();
  out.spacing_mm_ = spacing_mm_;
  out.sums_.assign(static_cast<std::size_t>(size_[0]) + 2 * kEnds, Eigen::Vector3d::Zero());
  for (int i = 0; i < size_[0]; ++i) {
    Eigen::Vector3d& sum = out.sums_[static_cast<std::size_t>(i) + kEnds];
    for (std::size_t c = at->begin[2]; c < at->end[2]; ++c) {
      for (std::size_t b = at->begin[1]; b < at->end[1]; ++b) {
        // The first near control point is one before the line's own cell.
        const int n = index(*at, 0, b, c) - at->first[0] + i;
        sum += at->weights[2].value[c] * at->weights[1].value[b] * coefficients_.segment<3>(3 * n);
      }
    }
  }
  return out;
}

Eigen::Vector3d SplineField::Row::displacement(double x_ct_mm) const {
  const double at = (x_ct_mm - origin_mm_) / spacing_mm_;
  // In the padded sums, the four that affect a cell begin at its number plus one.
  const double cells = static_cast<double>(sums_.size()) - 4;
  if (sums_.empty() || !(at > -1 && at < cells + 1)) return Eigen::Vector3d::Zero();
  const double cell = std::floor(at);
  const Four weights = cubic(at - cell);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t a = 0; a < 4; ++a) {
    const std::size_t n = static_cast<std::size_t>(cell + 1) + a;
    if (n < sums_.size()) sum += weights.value[a] * sums_[n];
  }
  return sum;
}

Eigen::Matrix3d SplineField::jacobian(const Eigen::Vector3d& p) const {
  const Reach near = reach(p);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t n = 0; n < static_cast<std::size_t>(near.count); ++n) {
    sum += coefficients_.segment<3>(3 * near.index[n]) * near.slope[n].transpose();
  }
  return sum;
}

double SplineField::min_determinant() const {
  const double step = 0.25 * spacing_mm_;
  double least = 1;
  for (double z = box_.low.z(); z <= box_.high.z(); z += step) {
    for (double y = box_.low.y(); y <= box_.high.y(); y += step) {
      for (double x = box_.low.x(); x <= box_.high.x(); x += step) {
        const Eigen::Matrix3d map = Eigen::Matrix3d::Identity() + jacobian({x, y, z});
        least = std::min(least, map.determinant());
      }
    }
  }
  return least;
}

double SplineField::gradient_bound() const {
  double squares = 0;
  const std::array<int, 3> stride = {1, size_[0], size_[0] * size_[1]};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double steepest = 0;
    for (int n = 0; n < control_points(); ++n) {
      const int place = n / stride[axis] % size_[axis];
      const Eigen::Vector3d here = coefficients_.segment<3>(3 * n);
      // Beyond the last control point the field is zero.
      const Eigen::Vector3d next =
          place + 1 < size_[axis]
              ? Eigen::Vector3d(coefficients_.segment<3>(3 * (n + stride[axis])))
              : Eigen::Vector3d::Zero();
      steepest = std::max(steepest, (next - here).norm());
      if (place == 0) steepest = std::max(steepest, here.norm());
    }
    squares += steepest * steepest;
  }
  return std::sqrt(squares) / spacing_mm_;
}

double SplineField::bending_energy_mm() const {
  using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  const Eigen::Map<const Points> c(coefficients_.data(), control_points(), 3);
  return (c.array() * (bending() * c).array()).sum();
}

Eigen::SparseMatrix<double> SplineField::bending() const {
  // Pairs of second derivatives: xx, yy, zz once, xy, xz, yz twice. Each product of three
  // one-dimensional integrals has the scale h³ / h⁴.
  constexpr std::array<std::array<std::size_t, 4>, 6> kTerms = {
      {{2, 0, 0, 1}, {0, 2, 0, 1}, {0, 0, 2, 1}, {1, 1, 0, 2}, {1, 0, 1, 2}, {0, 1, 1, 2}}};
  std::vector<Eigen::Triplet<double>> triplets;
  const auto product = [&](int dx, int dy, int dz) {
    double sum = 0;
    for (const auto& t : kTerms) {
      sum += static_cast<double>(t[3]) * kProducts[t[0]][static_cast<std::size_t>(std::abs(dx))] *
             kProducts[t[1]][static_cast<std::size_t>(std::abs(dy))] *
             kProducts[t[2]][static_cast<std::size_t>(std::abs(dz))];
    }
    return sum / spacing_mm_;
  };
  for (int row = 0; row < control_points(); ++row) {
    const int i = row % size_[0], j = row / size_[0] % size_[1], k = row / size_[0] / size_[1];
    for (int dk = std::max(-3, -k); dk <= std::min(3, size_[2] - 1 - k); ++dk) {
      for (int dj = std::max(-3, -j); dj <= std::min(3, size_[1] - 1 - j); ++dj) {
        for (int di = std::max(-3, -i); di <= std::min(3, size_[0] - 1 - i); ++di) {
          triplets.emplace_back(row, row + di + size_[0] * (dj + size_[1] * dk),
                                product(di, dj, dk));
        }
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(control_points(), control_points());
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

void SplineField::set_coefficients(const Eigen::VectorXd& mm) {
  NAV_CHECK(mm.size() == coefficients_.size() && mm.allFinite(), mm.size());
  coefficients_ = mm;
}

}  // namespace nav::registration
