// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/ct_texels.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iomanip>
#include <limits>
#include <memory>
#include <numeric>
#include <sstream>

#include "nav/check.hpp"
#include "nav/index.hpp"

namespace nav::registration {
namespace {

// HU range of soft tissue; bone and air have no finer structure that ultrasound could show.
constexpr std::int16_t kLowHu = -150;
constexpr std::int16_t kHighHu = 250;
constexpr double kFinestTexelMm = 1.0;
constexpr double kMaxTexels = 24e6;  // 384 MB

// Largest number of voxels whose sum of clamped HU fits into 16 bits.
constexpr int kMostShortVoxels = 128;

/// Half of a normalised Gaussian out to three sigmas, for an axis of \p texels texels. Weights that
/// always fall on the repeated end, for any texel, are combined into one: an axis of a few thin
/// voxels would otherwise take millions of weights.
std::vector<float> half_gaussian(double sigma_texels, int texels) {
  const double sigma = std::max(sigma_texels, 1e-3);
  const int radius = std::max(1, static_cast<int>(std::ceil(3 * sigma_texels)));
  std::vector<double> weights;
  double total = 0;
  for (int t = 0; t <= radius; ++t) {
    weights.push_back(std::exp(-0.5 * t * t / (sigma * sigma)));
    total += (t == 0 ? 1 : 2) * weights.back();
  }
  const std::size_t last = as_size(std::max(texels - 1, 1));
  if (weights.size() > last + 1) {
    const auto beyond = weights.begin() + static_cast<std::ptrdiff_t>(last + 1);
    weights[last] += std::accumulate(beyond, weights.end(), 0.0);
    weights.resize(last + 1);
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

/// Texels along i of one row, both ends included; the empty run can be widened to any other.
struct Run {
  int low = std::numeric_limits<int>::max();
  int high = std::numeric_limits<int>::lowest();

  [[nodiscard]] bool empty() const { return low > high; }
  [[nodiscard]] std::size_t count() const { return as_size(high - low + 1); }
  void widen(const Run& to) {
    low = std::min(low, to.low);
    high = std::max(high, to.high);
  }
};

/// One axis of the computation, in texels of the lattice.
struct Axis {
  int texels;  ///< Number of texels of the lattice.
  int radius;  ///< Radius of the Gaussian.
  /// Smoothed texels: those requested, and one more on each side for their differences.
  int low = 0, high = 0;
  int means_low = 0, means_high = 0;  ///< Block means: those within reach of the Gaussian.

  [[nodiscard]] int held(int texel) const { return std::clamp(texel, 0, texels - 1); }
  [[nodiscard]] std::size_t smoothed() const { return as_size(high - low + 1); }
  [[nodiscard]] std::size_t means() const { return as_size(means_high - means_low + 1); }
};

Axis axis_of(const TexelLattice& lattice, std::span<const TexelOrder> orders, std::size_t a) {
  Axis axis{.texels = lattice.size[a], .radius = static_cast<int>(lattice.kernel[a].size()) - 1};
  axis.low = axis.texels;
  for (const TexelOrder& order : orders) {
    axis.low = std::min(axis.low, axis.held(order.part.first[a] - 1));
    axis.high = std::max(axis.high, axis.held(order.part.first[a] + order.part.size[a]));
  }
  axis.means_low = axis.held(axis.low - axis.radius);
  axis.means_high = axis.held(axis.high + axis.radius);
  return axis;
}

/// Computes the texels of all orders in one pass, slice by slice, so that the inputs stay in the
/// cache. It keeps as many slices of block means, smoothed along j and i, as the Gaussian along k
/// reaches, and the last three of those smoothed along k, for the differences. In each row it
/// computes only the run that some order needs.
class TexelMaker {
 public:
  TexelMaker(const Volume& ct, const TexelLattice& lattice, std::span<const TexelOrder> orders)
      : ct_(ct),
        lattice_(lattice),
        orders_(orders),
        i_(axis_of(lattice, orders, 0)),
        j_(axis_of(lattice, orders, 1)),
        k_(axis_of(lattice, orders, 2)),
        smooth_runs_(j_.smoothed() * k_.smoothed()),
        kept_runs_(j_.smoothed() * k_.means()),
        mean_runs_(j_.means()),
        row_(i_.smoothed() + 2 * as_size(i_.radius)),
        slice_(i_.smoothed() * j_.smoothed()),
        means_(uninitialised(row_ * j_.means())),
        along_j_(uninitialised(row_)),
        reach_(2 * k_.radius + 1),
        kept_(uninitialised(slice_ * as_size(reach_))),
        smooth_(uninitialised(slice_ * as_size(kSmoothed))) {
    find_runs();
  }

  void make() {
    std::vector<int> filled(orders_.size());  // Filled slices of each order.
    int source = k_.means_low;
    int smooth = k_.low;
    for (int k = k_.low; k <= k_.high; ++k) {
      for (; smooth <= std::min(k + 1, k_.high); ++smooth) {
        for (; source <= k_.held(smooth + k_.radius); ++source) smooth_slice(source);
        smooth_along_k(smooth);
      }
      for (std::size_t n = 0; n < orders_.size(); ++n) {
        const TexelPart& part = orders_[n].part;
        for (int& at = filled[n]; at < part.size[2] && k_.held(part.first[2] + at) == k; ++at) {
          fill_slice(orders_[n], at);
        }
      }
    }
  }

 private:
  static std::unique_ptr<float[]> uninitialised(std::size_t count) {
    return std::make_unique_for_overwrite<float[]>(count);
  }

  Run& smooth_run(int j, int k) {
    return smooth_runs_[as_size(k - k_.low) * j_.smoothed() + as_size(j - j_.low)];
  }
  Run& kept_run(int j, int k) {
    return kept_runs_[as_size(k - k_.means_low) * j_.smoothed() + as_size(j - j_.low)];
  }

  /// Finds the runs that must be smoothed for the orders, and those that must be kept for this.
  void find_runs() {
    for (const TexelOrder& order : orders_) {
      const auto& [first, size] = order.part;
      std::size_t row = 0;
      for (int k = first[2]; k < first[2] + size[2]; ++k) {
        for (int j = first[1]; j < first[1] + size[1]; ++j) {
          const TexelRun run = order.runs[row++];
          if (run.to <= run.from) continue;
          const Run own{i_.held(first[0] + run.from), i_.held(first[0] + run.to - 1)};
          const int y = j_.held(j);
          const int z = k_.held(k);
          smooth_run(y, z).widen({i_.held(own.low - 1), i_.held(own.high + 1)});
          smooth_run(j_.held(y - 1), z).widen(own);
          smooth_run(j_.held(y + 1), z).widen(own);
          smooth_run(y, k_.held(z - 1)).widen(own);
          smooth_run(y, k_.held(z + 1)).widen(own);
        }
      }
    }
    for (int k = k_.low; k <= k_.high; ++k) {
      for (int t = -k_.radius; t <= k_.radius; ++t) {
        Run* kept = &kept_run(j_.low, k_.held(k + t));
        const Run* smooth = &smooth_run(j_.low, k);
        for (std::size_t j = 0; j < j_.smoothed(); ++j) kept[j].widen(smooth[j]);
      }
    }
  }

  /// Block means of a run of texels; the ends of the lattice are repeated.
  void mean_run(int j, int k, const Run& run, float* out) {
    const int low = i_.held(run.low);
    const int count = i_.held(run.high) - low + 1;
    const int block = lattice_.block[0];
    const int rows = lattice_.block[1] * lattice_.block[2];
    const float scale = 1.0f / (kHuPerUnit * static_cast<float>(block * rows));
    float* inside = out + (low - run.low);
    if (block == 1 && rows == 1) {
      const std::int16_t* from = voxels(low, j, k);
      for (int i = 0; i < count; ++i) inside[i] = scale * static_cast<float>(held_hu(from[i]));
    } else if (block * rows <= kMostShortVoxels) {
      mean_of_rows(low, count, j, k, scale, short_sums_, inside);
    } else {
      mean_of_rows(low, count, j, k, scale, sums_, inside);
    }
    std::fill(out, inside, inside[0]);
    std::fill(inside + count, out + run.count(), inside[count - 1]);
  }

  static std::int16_t held_hu(std::int16_t hu) { return std::min(std::max(hu, kLowHu), kHighHu); }

  /// Pointer to the first voxel of a texel, in row y and slice z of its block.
  [[nodiscard]] const std::int16_t* voxels(int i, int j, int k, int y = 0, int z = 0) const {
    const auto& n = ct_.grid().size;
    const std::size_t slice = as_size(lattice_.first[2] + k * lattice_.block[2] + z);
    const std::size_t row =
        slice * as_size(n[1]) + as_size(lattice_.first[1] + j * lattice_.block[1] + y);
    return &ct_.hu()[row * as_size(n[0]) + as_size(lattice_.first[0] + i * lattice_.block[0])];
  }

  /// Block means of texels from low on: first sums over the rows and slices of blocks for each
  /// voxel of a row, then sums along the row.
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
    add_along(block, sums);
    const Sum* sum = sums.data();
    for (int i = 0; i < count; ++i, sum += block) out[i] = scale * static_cast<float>(*sum);
  }

  /// Adds the next block − 1 elements to each element that begins a block; the other elements
  /// become meaningless.
  template <class Sum>
  static void add_along(int block, std::vector<Sum>& sums) {
    switch (block) {
      case 1:
        return;
      case 2:
        return add_next<2>(sums);
      case 3:
        return add_next<3>(sums);
      case 4:
        return add_next<4>(sums);
      default:
        break;
    }
    const std::size_t step = as_size(block);
    for (std::size_t i = 0; i < sums.size(); i += step) {
      for (std::size_t b = 1; b < step; ++b) sums[i] = static_cast<Sum>(sums[i] + sums[i + b]);
    }
  }

  /// Adds to all elements, although only every kBlock-th is needed, because this can be vectorised.
  template <std::size_t kBlock, class Sum>
  static void add_next(std::vector<Sum>& sums) {
    Sum* sum = sums.data();
    for (std::size_t i = 0; i + kBlock <= sums.size(); ++i) {
      Sum total = sum[i];
      for (std::size_t b = 1; b < kBlock; ++b) total = static_cast<Sum>(total + sum[i + b]);
      sum[i] = total;
    }
  }

  /// Row of block means; texel i is at index i − i_.low + the Gaussian's radius.
  float* means(int j) { return &means_[as_size(j - j_.means_low) * row_]; }
  float* kept(int j, int k) {
    return &kept_[as_size((k - k_.means_low) % reach_) * slice_ +
                  as_size(j - j_.low) * i_.smoothed()];
  }
  float* smoothed(int j, int k) {
    return &smooth_[as_size((k - k_.low) % kSmoothed) * slice_ +
                    as_size(j - j_.low) * i_.smoothed()];
  }

  /// Block means of a slice, smoothed along j and i.
  void smooth_slice(int k) {
    std::fill(mean_runs_.begin(), mean_runs_.end(), Run{});
    for (int j = j_.low; j <= j_.high; ++j) {
      const Run& run = kept_run(j, k);
      if (run.empty()) continue;
      for (int t = -j_.radius; t <= j_.radius; ++t) {
        mean_runs_[as_size(j_.held(j + t) - j_.means_low)].widen(run);
      }
    }
    for (int j = j_.means_low; j <= j_.means_high; ++j) {
      const Run& run = mean_runs_[as_size(j - j_.means_low)];
      if (run.empty()) continue;
      mean_run(j, k, {run.low - i_.radius, run.high + i_.radius}, means(j) + (run.low - i_.low));
    }
    for (int j = j_.low; j <= j_.high; ++j) {
      const Run& run = kept_run(j, k);
      if (run.empty()) continue;
      const int at = run.low - i_.low;
      rows_.clear();
      for (int t = -j_.radius; t <= j_.radius; ++t) rows_.push_back(means(j_.held(j + t)) + at);
      weighted_sum(rows_, run.count() + 2 * as_size(i_.radius), lattice_.kernel[1], along_j_.get());
      rows_.clear();
      for (int t = 0; t <= 2 * i_.radius; ++t) rows_.push_back(along_j_.get() + t);
      weighted_sum(rows_, run.count(), lattice_.kernel[0], kept(j, k) + at);
    }
  }

  void smooth_along_k(int k) {
    for (int j = j_.low; j <= j_.high; ++j) {
      const Run& run = smooth_run(j, k);
      if (run.empty()) continue;
      const int at = run.low - i_.low;
      rows_.clear();
      for (int t = -k_.radius; t <= k_.radius; ++t) {
        rows_.push_back(kept(j, k_.held(k + t)) + at);
      }
      weighted_sum(rows_, run.count(), lattice_.kernel[2], smoothed(j, k) + at);
    }
  }

  void fill_slice(const TexelOrder& order, int slice) {
    const auto& [first, size] = order.part;
    for (int j = 0; j < size[1]; ++j) {
      const std::size_t row = as_size(slice) * as_size(size[1]) + as_size(j);
      const TexelRun& run = order.runs[row];
      if (run.to <= run.from) continue;
      fill_row(j_.held(first[1] + j), k_.held(first[2] + slice), first[0], run,
               &order.out[row * as_size(size[0])]);
    }
  }

  /// Computes central differences inside and one-sided ones at the lattice's border; a single layer
  /// has no gradient.
  void fill_row(int j, int k, int first, const TexelRun& run, std::array<float, 4>* row) {
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
      const int held = i_.held(first + t);
      const int last = i_.held(held - 1);
      const int next = i_.held(held + 1);
      row[t] = texel(held - i_.low, last - i_.low, next - i_.low,
                     per(lattice_.gradient_scale[0], next - last));
    };
    const float by_i = per(lattice_.gradient_scale[0], 2);
    const int offset = first - i_.low;
    // The range in which both neighbours lie in the lattice.
    const int from = std::clamp(1 - first, run.from, run.to);
    const int to = std::clamp(i_.texels - 1 - first, from, run.to);
    for (int t = run.from; t < from; ++t) edge(t);
    for (int t = from; t < to; ++t) {
      row[t] = texel(offset + t, offset + t - 1, offset + t + 1, by_i);
    }
    for (int t = to; t < run.to; ++t) edge(t);
  }

  static constexpr int kSmoothed = 3;

  const Volume& ct_;
  const TexelLattice& lattice_;
  std::span<const TexelOrder> orders_;
  Axis i_, j_, k_;
  std::vector<Run> smooth_runs_, kept_runs_, mean_runs_;
  // Number of floats of a row of block means, and of a slice smoothed along i.
  std::size_t row_, slice_;
  std::unique_ptr<float[]> means_, along_j_;
  int reach_;  // Number of slices that the Gaussian along k needs.
  std::unique_ptr<float[]> kept_, smooth_;
  std::vector<const float*> rows_;
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
      const double gap = std::max(low[axis] - last, -high[axis]) * grid.spacing_mm[axis];
      std::ostringstream text;
      text << std::fixed << std::setprecision(1) << ct.name()
           << ": expected the sweep to overlap the CT, found it entirely outside along axis "
           << axis << ", " << gap << " mm beyond the reach of the search about its pose";
      return Error{ErrorCode::kRefused, text.str()};
    }
    const int from = static_cast<int>(std::floor(std::max(low[axis], 0.0)));
    const int to = static_cast<int>(std::ceil(std::min(high[axis], static_cast<double>(last))));
    const int voxels = to - from + 1;
    // At least two texels, so that interpolation is possible.
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
    lattice.kernel[a] = half_gaussian(
        std::sqrt(std::max(sigma_mm * sigma_mm - have, 0.0)) / channels.spacing_mm[axis],
        lattice.size[a]);
  }
  channels.origin_ct_mm = grid.at(first).mm;
  lattice.gradient_scale = (sigma_mm * channels.spacing_mm.cwiseInverse()).cast<float>();
  return lattice;
}

void fill_texels(const Volume& ct, const TexelLattice& lattice,
                 std::span<const TexelOrder> orders) {
  for (const TexelOrder& order : orders) {
    const auto& size = order.part.size;
    const std::size_t rows = as_size(size[1]) * as_size(size[2]);
    NAV_CHECK(order.runs.size() == rows, order.runs.size(), rows);
    NAV_CHECK(order.out.size() == rows * as_size(size[0]), order.out.size(), rows);
  }
  if (!orders.empty()) TexelMaker(ct, lattice, orders).make();
}

void fill_texels(const Volume& ct, const TexelLattice& lattice, const TexelPart& part,
                 TexelArray& out) {
  const std::size_t rows = as_size(part.size[1]) * as_size(part.size[2]);
  out.resize(rows * as_size(part.size[0]));
  const std::vector<TexelOrder> all{
      {part, std::vector<TexelRun>(rows, {0, part.size[0]}), std::span(out)}};
  fill_texels(ct, lattice, all);
}

}  // namespace nav::registration
