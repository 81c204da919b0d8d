// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/ct_texels.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "nav/index.hpp"

namespace nav::registration {
namespace {

// Soft tissue; bone and air carry no finer structure that ultrasound could show.
constexpr std::int16_t kLowHu = -150;
constexpr std::int16_t kHighHu = 250;
constexpr double kFinestTexelMm = 1.0;
constexpr double kMaxTexels = 24e6;  // 384 MB

// So many voxels of the window's ends fit into 16 bits.
constexpr int kMostShortRows = 128;

/// Half of a normalised Gaussian out to three sigmas.
std::vector<float> half_gaussian(double sigma_texels) {
  const double sigma = std::max(sigma_texels, 1e-3);
  const int radius = std::max(1, static_cast<int>(std::ceil(3 * sigma_texels)));
  std::vector<double> weights;
  double total = 0;
  for (int t = 0; t <= radius; ++t) {
    weights.push_back(std::exp(-0.5 * t * t / (sigma * sigma)));
    total += (t == 0 ? 1 : 2) * weights.back();
  }
  std::vector<float> kernel;
  for (const double weight : weights) kernel.push_back(static_cast<float>(weight / total));
  return kernel;
}

/// out[i] = Σ_t kernel[|t|] rows[t + radius][i].
template <std::size_t kRadius>
void weighted_sum(const std::vector<const float*>& rows, std::size_t count,
                  const std::vector<float>& kernel, float* out) {
  std::array<const float*, 2 * kRadius + 1> in;
  std::array<float, kRadius + 1> k;
  std::copy_n(rows.begin(), in.size(), in.begin());
  std::copy_n(kernel.begin(), k.size(), k.begin());
  for (std::size_t i = 0; i < count; ++i) {
    float sum = k[0] * in[kRadius][i];
    for (std::size_t t = 1; t <= kRadius; ++t) {
      sum += k[t] * (in[kRadius - t][i] + in[kRadius + t][i]);
    }
    out[i] = sum;
  }
}

void weighted_sum(const std::vector<const float*>& rows, std::size_t count,
                  const std::vector<float>& kernel, float* out) {
  switch (kernel.size() - 1) {
    case 1:
      return weighted_sum<1>(rows, count, kernel, out);
    case 2:
      return weighted_sum<2>(rows, count, kernel, out);
    case 3:
      return weighted_sum<3>(rows, count, kernel, out);
    case 4:
      return weighted_sum<4>(rows, count, kernel, out);
    default:
      break;
  }
  const std::size_t radius = kernel.size() - 1;
  for (std::size_t i = 0; i < count; ++i) out[i] = kernel[0] * rows[radius][i];
  for (std::size_t t = 1; t <= radius; ++t) {
    const float* before = rows[radius - t];
    const float* after = rows[radius + t];
    for (std::size_t i = 0; i < count; ++i) out[i] += kernel[t] * (before[i] + after[i]);
  }
}

/// The same along an axis of one array, whose neighbours lie stride apart.
void convolve(const float* in, std::size_t stride, std::size_t count,
              const std::vector<float>& kernel, float* out) {
  std::vector<const float*> rows;
  for (std::size_t t = 0; t < 2 * kernel.size() - 1; ++t) rows.push_back(in + t * stride);
  weighted_sum(rows, count, kernel, out);
}

/// One axis of a part: what is filled, what is smoothed for its differences, what that is made of.
struct Axis {
  int first, size;         ///< Texels to be filled.
  int low, count;          ///< Smoothed: one more on each side, within the lattice.
  int source_low, source;  ///< Block means: as far as the Gaussian reaches; clamped to the lattice.
  int texels;              ///< Of the lattice.

  [[nodiscard]] int held(int texel) const { return std::clamp(texel, 0, texels - 1); }
};

Axis axis_of(const TexelLattice& lattice, const TexelPart& part, std::size_t a) {
  Axis axis{part.first[a], part.size[a], 0, 0, 0, 0, lattice.size[a]};
  const int radius = static_cast<int>(lattice.kernel[a].size()) - 1;
  axis.low = axis.held(axis.first - 1);
  axis.count = axis.held(axis.first + axis.size) - axis.low + 1;
  axis.source_low = axis.low - radius;
  axis.source = axis.count + 2 * radius;
  return axis;
}

/// Makes the texels of one part slice by slice, so that what they are made of stays in the cache:
/// block means, smoothed along i and j, as many as the Gaussian along k reaches; of those that it
/// has smoothed the last three, for the differences.
class PartMaker {
 public:
  PartMaker(const Volume& ct, const TexelLattice& lattice, const TexelPart& part)
      : ct_(ct),
        lattice_(lattice),
        i_(axis_of(lattice, part, 0)),
        j_(axis_of(lattice, part, 1)),
        k_(axis_of(lattice, part, 2)),
        row_(as_size(i_.source)),
        slice_(row_ * as_size(j_.count)),
        means_(row_ * as_size(j_.source)),
        smooth_j_(slice_),
        reach_(2 * static_cast<int>(lattice.kernel[2].size()) - 1),
        kept_(slice_ * as_size(reach_)),
        smooth_(slice_ * as_size(kSmoothed)) {}

  void append(std::vector<std::array<float, 4>>& out) {
    out.reserve(out.size() + as_size(i_.size) * as_size(j_.size) * as_size(k_.size));
    // Row by row, as memory that is only made larger would be cleared first.
    std::vector<std::array<float, 4>> row(as_size(i_.size));
    int source = 0;  // Slices made so far, and those smoothed along k.
    int smooth = 0;
    for (int k = k_.first; k < k_.first + k_.size; ++k) {
      for (; smooth <= k_.held(k_.held(k) + 1) - k_.low; ++smooth) {
        for (; source < smooth + reach_; ++source) smooth_slice(source);
        smooth_along_k(smooth);
      }
      for (int j = j_.first; j < j_.first + j_.size; ++j) {
        fill_row(j_.held(j), k_.held(k), row.data());
        out.insert(out.end(), row.begin(), row.end());
      }
    }
  }

 private:
  /// Block means of a row of texels, the ends repeated.
  void mean_row(int j, int k, float* out) {
    const int low = i_.held(i_.source_low);
    const int count = i_.held(i_.source_low + i_.source - 1) - low + 1;
    const int block = lattice_.block[0];
    const int rows = lattice_.block[1] * lattice_.block[2];
    const float scale = 1.0f / (kHuPerUnit * static_cast<float>(block * rows));
    float* inside = out + (low - i_.source_low);
    if (block == 1 && rows == 1) {
      const std::int16_t* from = voxels(low, j, k);
      for (int i = 0; i < count; ++i) inside[i] = scale * static_cast<float>(held_hu(from[i]));
    } else if (rows <= kMostShortRows) {
      mean_of_rows(low, count, j, k, scale, short_sums_, inside);
    } else {
      mean_of_rows(low, count, j, k, scale, sums_, inside);
    }
    std::fill(out, inside, inside[0]);
    std::fill(inside + count, out + i_.source, inside[count - 1]);
  }

  static std::int16_t held_hu(std::int16_t hu) { return std::min(std::max(hu, kLowHu), kHighHu); }

  /// The voxels of a texel on from its first, of row y and slice z of its block.
  [[nodiscard]] const std::int16_t* voxels(int i, int j, int k, int y = 0, int z = 0) const {
    const auto& n = ct_.grid().size;
    const std::size_t slice = as_size(lattice_.first[2] + k * lattice_.block[2] + z);
    const std::size_t row =
        slice * as_size(n[1]) + as_size(lattice_.first[1] + j * lattice_.block[1] + y);
    return &ct_.hu()[row * as_size(n[0]) + as_size(lattice_.first[0] + i * lattice_.block[0])];
  }

  /// Of texels from low on: sums over the rows and slices of blocks for each voxel of a row, then
  /// along it.
  template <class Sum>
  void mean_of_rows(int low, int count, int j, int k, float scale, std::vector<Sum>& sums,
                    float* out) {
    const int block = lattice_.block[0];
    sums.assign(as_size(count * block), 0);
    for (int z = 0; z < lattice_.block[2]; ++z) {
      for (int y = 0; y < lattice_.block[1]; ++y) {
        const std::int16_t* from = voxels(low, j, k, y, z);
        Sum* to = sums.data();
        for (std::size_t i = 0; i < sums.size(); ++i) {
          to[i] = static_cast<Sum>(to[i] + held_hu(from[i]));
        }
      }
    }
    const Sum* sum = sums.data();
    for (int i = 0; i < count; ++i) {
      std::int32_t total = 0;
      for (int b = 0; b < block; ++b) total += *sum++;
      out[i] = scale * static_cast<float>(total);
    }
  }

  /// Source slice k: block means smoothed along j and i.
  void smooth_slice(int k) {
    float* to = &kept_[as_size(k % reach_) * slice_];
    const int texel = k_.held(k_.source_low + k);
    if (k > 0 && texel == k_.held(k_.source_low + k - 1)) {
      std::copy_n(&kept_[as_size((k - 1) % reach_) * slice_], slice_, to);
      return;
    }
    for (int j = 0; j < j_.source; ++j) {
      const int held = j_.held(j_.source_low + j);
      float* row = &means_[as_size(j) * row_];
      if (j > 0 && held == j_.held(j_.source_low + j - 1)) {
        std::copy_n(row - row_, row_, row);
      } else {
        mean_row(held, texel, row);
      }
    }
    convolve(means_.data(), row_, slice_, lattice_.kernel[1], smooth_j_.data());
    const std::size_t reach = 2 * (lattice_.kernel[0].size() - 1);
    convolve(smooth_j_.data(), 1, slice_ - reach, lattice_.kernel[0], to);
  }

  void smooth_along_k(int k) {
    std::vector<const float*> rows;
    for (int t = 0; t < reach_; ++t) rows.push_back(&kept_[as_size((k + t) % reach_) * slice_]);
    weighted_sum(rows, slice_, lattice_.kernel[2], &smooth_[as_size(k % kSmoothed) * slice_]);
  }

  /// Of a texel's row that was smoothed; its texel i lies at i − i_.low.
  [[nodiscard]] const float* smoothed(int j, int k) const {
    return &smooth_[as_size((k - k_.low) % kSmoothed) * slice_ + as_size(j - j_.low) * row_];
  }

  /// Central differences inside, one-sided at the lattice's border; a single layer has no gradient.
  void fill_row(int j, int k, std::array<float, 4>* row) const {
    const int last_j = j_.held(j - 1);
    const int next_j = j_.held(j + 1);
    const int last_k = k_.held(k - 1);
    const int next_k = k_.held(k + 1);
    const auto per = [](float unit, int steps) {
      return steps > 0 ? unit / static_cast<float>(steps) : 0.0f;
    };
    const float by_j = per(lattice_.gradient_scale[1], next_j - last_j);
    const float by_k = per(lattice_.gradient_scale[2], next_k - last_k);
    const float* here = smoothed(j, k);
    const float* j0 = smoothed(last_j, k);
    const float* j1 = smoothed(next_j, k);
    const float* k0 = smoothed(j, last_k);
    const float* k1 = smoothed(j, next_k);
    const auto texel = [&](int i, int low, int high, float by_i) {
      return std::array<float, 4>{here[i], by_i * (here[high] - here[low]), by_j * (j1[i] - j0[i]),
                                  by_k * (k1[i] - k0[i])};
    };
    const auto edge = [&](int t) {
      const int held = i_.held(i_.first + t);
      const int last = i_.held(held - 1);
      const int next = i_.held(held + 1);
      row[t] = texel(held - i_.low, last - i_.low, next - i_.low,
                     per(lattice_.gradient_scale[0], next - last));
    };
    const float by_i = per(lattice_.gradient_scale[0], 2);
    const int offset = i_.first - i_.low;
    for (int t = 1; t + 1 < i_.size; ++t) {
      row[t] = texel(offset + t, offset + t - 1, offset + t + 1, by_i);
    }
    edge(0);
    edge(i_.size - 1);
  }

  static constexpr int kSmoothed = 3;

  const Volume& ct_;
  const TexelLattice& lattice_;
  Axis i_, j_, k_;
  std::size_t row_, slice_;  // Floats of a source row, and of a slice smoothed along j.
  std::vector<float> means_, smooth_j_;
  int reach_;  // Slices of the Gaussian along k.
  std::vector<float> kept_, smooth_;
  std::vector<std::int16_t> short_sums_;
  std::vector<std::int32_t> sums_;
};

}  // namespace

Result<TexelLattice> lattice_over(const Volume& ct, const CtBox& box, double sigma_mm,
                                  double texel_sigmas, CtChannels& channels) {
  const VoxelGrid& grid = ct.grid();
  double texel_mm = std::max(texel_sigmas * sigma_mm, kFinestTexelMm);
  const Eigen::Vector3d extent = (box.high - box.low).cwiseMin(grid.extent_mm().norm());
  texel_mm = std::max(texel_mm, std::cbrt(extent.prod() / kMaxTexels));
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
  TexelLattice lattice{};
  Eigen::Vector3d first;
  channels.directions = grid.directions;
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
    const int wanted = static_cast<int>(std::lround(texel_mm / grid.spacing_mm[axis]));
    const int block = std::clamp(wanted, 1, std::max(voxels / 2, 1));
    lattice.first[a] = from;
    lattice.block[a] = block;
    lattice.size[a] = std::max(voxels / block, 1);
    channels.size[a] = std::max(lattice.size[a], 2);
    channels.spacing_mm[axis] = grid.spacing_mm[axis] * block;
    first[axis] = from + 0.5 * (block - 1);
    // A block mean already has the variance (b² − 1)/12 voxels².
    const double have = (block * block - 1) / 12.0 * grid.spacing_mm[axis] * grid.spacing_mm[axis];
    lattice.kernel[a] = half_gaussian(std::sqrt(std::max(sigma_mm * sigma_mm - have, 0.0)) /
                                      channels.spacing_mm[axis]);
  }
  channels.origin_ct_mm = grid.at(first).mm;
  lattice.gradient_scale = (sigma_mm * channels.spacing_mm.cwiseInverse()).cast<float>();
  return lattice;
}

void append_texels(const Volume& ct, const TexelLattice& lattice, const TexelPart& part,
                   std::vector<std::array<float, 4>>& out) {
  PartMaker(ct, lattice, part).append(out);
}

}  // namespace nav::registration
