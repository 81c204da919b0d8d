// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/ct_channels.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "nav/index.hpp"

namespace nav::registration {
namespace {

// Soft tissue; bone and air carry no finer structure that ultrasound could show.
constexpr float kLowHu = -150;
constexpr float kHighHu = 250;
constexpr double kTexelsPerSigma = 1 / 0.7;
constexpr double kFinestTexelMm = 1.0;
constexpr double kMaxTexels = 24e6;  // 384 MB

/// Part of the CT's voxels: first index and count, and how many are averaged into one texel.
struct Crop {
  std::array<int, 3> first, block, size;  ///< size in texels.
};

/// f at each texel: block means, i fastest.
struct Scalars {
  std::array<int, 3> size;
  std::vector<float> values;
  [[nodiscard]] std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) +
            static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(i);
  }
};

Result<Crop> crop_to(const Volume& ct, const CtBox& box, double texel_mm) {
  const VoxelGrid& grid = ct.grid();
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300);
  Eigen::Vector3d high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p((corner & 1) != 0 ? box.high.x() : box.low.x(),
                            (corner & 2) != 0 ? box.high.y() : box.low.y(),
                            (corner & 4) != 0 ? box.high.z() : box.low.z());
    const Eigen::Vector3d index = grid.index_of({p});
    low = low.cwiseMin(index);
    high = high.cwiseMax(index);
  }
  Crop crop{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const int last = grid.size[a] - 1;
    if (!(low[axis] <= last && high[axis] >= 0)) {
      return Error{ErrorCode::kRefused, ct.name() +
                                            ": expected the sweep to overlap the CT, found "
                                            "it wholly outside along axis " +
                                            std::to_string(axis)};
    }
    const int from = static_cast<int>(std::floor(std::max(low[axis], 0.0)));
    const int to = static_cast<int>(std::ceil(std::min(high[axis], static_cast<double>(last))));
    const int voxels = to - from + 1;
    // At least two texels, so that there is something to interpolate.
    const int block = static_cast<int>(std::lround(texel_mm / grid.spacing_mm[axis]));
    crop.block[a] = std::clamp(block, 1, std::max(voxels / 2, 1));
    crop.first[a] = from;
    crop.size[a] = std::max(voxels / crop.block[a], 1);
  }
  return crop;
}

Scalars block_means(const Volume& ct, const Crop& crop) {
  const auto& n = ct.grid().size;
  Scalars out{crop.size, {}};
  out.values.assign(out.index(0, 0, crop.size[2]), 0.0f);
  const float scale =
      1.0f / (kHuPerUnit * static_cast<float>(crop.block[0] * crop.block[1] * crop.block[2]));
  const auto hu = ct.hu();
  const int voxels = crop.size[0] * crop.block[0];
  std::vector<float> line(as_size(voxels));
  for (int k = 0; k < crop.size[2] * crop.block[2]; ++k) {
    for (int j = 0; j < crop.size[1] * crop.block[1]; ++j) {
      const std::size_t row =
          (static_cast<std::size_t>(k + crop.first[2]) * static_cast<std::size_t>(n[1]) +
           static_cast<std::size_t>(j + crop.first[1])) *
              static_cast<std::size_t>(n[0]) +
          static_cast<std::size_t>(crop.first[0]);
      float* target = &out.values[out.index(0, j / crop.block[1], k / crop.block[2])];
      for (int i = 0; i < voxels; ++i) {
        line[as_size(i)] =
            std::min(std::max(static_cast<float>(hu[row + as_size(i)]), kLowHu), kHighHu);
      }
      if (crop.block[0] == 1) {
        for (int i = 0; i < voxels; ++i) target[i] += scale * line[as_size(i)];
        continue;
      }
      const float* from = line.data();
      for (int i = 0; i < crop.size[0]; ++i) {
        float sum = 0;
        for (int b = 0; b < crop.block[0]; ++b) sum += *from++;
        target[i] += scale * sum;
      }
    }
  }
  return out;
}

/// Gaussian along k by hand, in place; OpenCV does i and j slice by slice.
void smooth(Scalars& f, const Eigen::Vector3d& sigma_texels) {
  const int ni = f.size[0];
  const int nj = f.size[1];
  const int nk = f.size[2];
  const auto radius = [](double sigma) {
    return std::max(1, static_cast<int>(std::ceil(3 * sigma)));
  };
  const int ri = radius(sigma_texels[0]);
  const int rj = radius(sigma_texels[1]);
  const cv::Mat ki = cv::getGaussianKernel(2 * ri + 1, std::max(sigma_texels[0], 1e-3), CV_32F);
  const cv::Mat kj = cv::getGaussianKernel(2 * rj + 1, std::max(sigma_texels[1], 1e-3), CV_32F);
  for (int k = 0; k < nk; ++k) {
    cv::Mat slice(nj, ni, CV_32F, &f.values[f.index(0, 0, k)]);
    cv::sepFilter2D(slice, slice, CV_32F, ki, kj, cv::Point(-1, -1), 0, cv::BORDER_REPLICATE);
  }
  // As an image whose rows are whole slices, k runs down.
  const int rk = radius(sigma_texels[2]);
  const cv::Mat kk = cv::getGaussianKernel(2 * rk + 1, std::max(sigma_texels[2], 1e-3), CV_32F);
  const cv::Mat one = cv::Mat::ones(1, 1, CV_32F);
  cv::Mat column(nk, ni * nj, CV_32F, f.values.data());
  cv::sepFilter2D(column, column, CV_32F, one, kk, cv::Point(-1, -1), 0, cv::BORDER_REPLICATE);
}

/// The texels of one row. Central differences inside, one-sided at the border; a single layer has
/// no gradient. scale: of a difference per texel.
void fill_row(const Scalars& f, int j, int k, const Eigen::Vector3f& scale,
              std::vector<std::array<float, 4>>& row) {
  const int last_j = std::max(j - 1, 0);
  const int next_j = std::min(j + 1, f.size[1] - 1);
  const int last_k = std::max(k - 1, 0);
  const int next_k = std::min(k + 1, f.size[2] - 1);
  const auto per = [](float unit, int steps) {
    return steps > 0 ? unit / static_cast<float>(steps) : 0.0f;
  };
  const float by_j = per(scale[1], next_j - last_j);
  const float by_k = per(scale[2], next_k - last_k);
  const float* here = &f.values[f.index(0, j, k)];
  const float* j0 = &f.values[f.index(0, last_j, k)];
  const float* j1 = &f.values[f.index(0, next_j, k)];
  const float* k0 = &f.values[f.index(0, j, last_k)];
  const float* k1 = &f.values[f.index(0, j, next_k)];
  const int n = f.size[0];
  const auto texel = [&](int i, int low, int high, float by_i) {
    return std::array<float, 4>{here[i], by_i * (here[high] - here[low]), by_j * (j1[i] - j0[i]),
                                by_k * (k1[i] - k0[i])};
  };
  const float by_i = per(scale[0], 2);
  for (int i = 1; i + 1 < n; ++i) row[as_size(i)] = texel(i, i - 1, i + 1, by_i);
  const int next = std::min(1, n - 1);
  const int last = std::max(n - 2, 0);
  row[0] = texel(0, 0, next, per(scale[0], next));
  row[as_size(n - 1)] = texel(n - 1, last, n - 1, per(scale[0], n - 1 - last));
  // A single texel is repeated.
  std::fill(row.begin() + n, row.end(), row[as_size(n - 1)]);
}

}  // namespace

CtBox box_of(const VoxelGrid& grid) {
  CtBox box{Eigen::Vector3d::Constant(1e300), Eigen::Vector3d::Constant(-1e300)};
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d index((corner & 1) != 0 ? grid.size[0] - 1 : 0,
                                (corner & 2) != 0 ? grid.size[1] - 1 : 0,
                                (corner & 4) != 0 ? grid.size[2] - 1 : 0);
    box.low = box.low.cwiseMin(grid.at(index).mm);
    box.high = box.high.cwiseMax(grid.at(index).mm);
  }
  return box;
}

Result<CtChannels> make_ct_channels(const Volume& ct, const CtBox& box, double sigma_mm) {
  const VoxelGrid& grid = ct.grid();
  double texel_mm = std::max(sigma_mm / kTexelsPerSigma, kFinestTexelMm);
  const Eigen::Vector3d extent = (box.high - box.low).cwiseMin(grid.extent_mm().norm());
  texel_mm = std::max(texel_mm, std::cbrt(extent.prod() / kMaxTexels));
  const auto crop = crop_to(ct, box, texel_mm);
  if (!crop) return crop.error();

  Scalars f = block_means(ct, *crop);
  CtChannels out;
  out.directions = grid.directions;
  Eigen::Vector3d first;
  Eigen::Vector3d sigma_texels;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const int block = crop->block[a];
    out.spacing_mm[axis] = grid.spacing_mm[axis] * block;
    first[axis] = crop->first[a] + 0.5 * (block - 1);
    // A block mean already has the variance (b² − 1)/12 voxels².
    const double have = (block * block - 1) / 12.0 * grid.spacing_mm[axis] * grid.spacing_mm[axis];
    sigma_texels[axis] =
        std::sqrt(std::max(sigma_mm * sigma_mm - have, 0.0)) / out.spacing_mm[axis];
  }
  out.origin_ct_mm = grid.at(first).mm;
  smooth(f, sigma_texels);

  for (std::size_t a = 0; a < 3; ++a) out.size[a] = std::max(f.size[a], 2);
  out.texels.reserve(as_size(out.size[0]) * as_size(out.size[1]) * as_size(out.size[2]));
  const Eigen::Vector3f scale = (sigma_mm * out.spacing_mm.cwiseInverse()).cast<float>();
  std::vector<std::array<float, 4>> row(as_size(out.size[0]));
  for (int k = 0; k < out.size[2]; ++k) {
    for (int j = 0; j < out.size[1]; ++j) {
      fill_row(f, std::min(j, f.size[1] - 1), std::min(k, f.size[2] - 1), scale, row);
      out.texels.insert(out.texels.end(), row.begin(), row.end());
    }
  }
  return out;
}

}  // namespace nav::registration
