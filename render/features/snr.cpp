// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/snr.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tbb/enumerable_thread_specific.h>

#include "nav/index.hpp"
#include "render/features/kernels.hpp"
#include "render/parallel.hpp"

namespace nav::render::features {
namespace {

/// Moments of several voxels.
struct Moments {
  std::vector<double> weight, mean, spread;
  void resize(std::size_t count) {
    weight.resize(count);
    mean.resize(count);
    spread.resize(count);
  }
  [[nodiscard]] MomentRows at(std::size_t first) {
    return {weight.data() + first, mean.data() + first, spread.data() + first};
  }
  [[nodiscard]] ConstMomentRows at(std::size_t first) const {
    return {weight.data() + first, mean.data() + first, spread.data() + first};
  }
};

struct MomentBuffers {
  std::vector<Moments> voxels;  ///< One row of each plane of the window.
  std::vector<float> row;
  Moments columns;  ///< Merged along k: a plane.
  Moments sheets;   ///< Merged along k and j: a row with borders of weight 0.
  Moments windows;  ///< Merged along all axes: a row.
  std::vector<ConstMomentRows> parts;
};

/// Merges windows along k, then j, then i. Each plane is computed separately, so nothing is
/// computed twice.
class SnrPlane {
 public:
  SnrPlane(const ScalarVolume& volume, const SnrOptions& options)
      : volume_(volume),
        size_(volume.grid().size),
        radius_(options.window_voxels / 2),
        stride_(padded(size_[0])),
        weights_(window_weights(options)),
        black_(options.black),
        floor_(volume.quantum() / std::sqrt(12.0)) {}

  void run(int k, float* out, MomentBuffers& s) const {
    allocate(s);
    for (int j = 0; j < size_[1]; ++j) merge_along_k(j, k, s);
    for (int j = 0; j < size_[1]; ++j) {
      merge_along_j(j, s);
      merge_along_i(s);
      volume_.read_row(j, k, s.row.data());
      write(s, out + as_size(j) * as_size(size_[0]));
    }
  }

 private:
  void allocate(MomentBuffers& s) const {
    const std::size_t stride = as_size(stride_);
    s.voxels.resize(weights_.size());
    for (auto& v : s.voxels) v.resize(stride);
    s.row.resize(stride);
    s.columns.resize(stride * as_size(size_[1]));
    s.sheets.resize(stride + 2 * as_size(radius_) + kLanes);
    s.windows.resize(stride);
  }
  void merge_along_k(int j, int k, MomentBuffers& s) const {
    s.parts.clear();
    std::size_t used = 0;
    const int first = std::max(k - radius_, 0);
    for (int z = first; z <= std::min(k + radius_, size_[2] - 1); ++z, ++used) {
      volume_.read_row(j, z, s.row.data());
      Moments& v = s.voxels[used];
      for (std::size_t i = 0; i < as_size(size_[0]); ++i) {
        const float f = s.row[i];
        v.weight[i] = f == f ? 1.0 : 0.0;
        v.mean[i] = f == f ? static_cast<double>(f) : 0.0;
      }
      s.parts.push_back(std::as_const(v).at(0));
    }
    kernels().merge_moments(s.parts.data(), &weights_[as_size(first - k + radius_)],
                            static_cast<int>(used), s.columns.at(as_size(j) * as_size(stride_)),
                            stride_);
  }
  void merge_along_j(int j, MomentBuffers& s) const {
    s.parts.clear();
    const int first = std::max(j - radius_, 0);
    for (int y = first; y <= std::min(j + radius_, size_[1] - 1); ++y) {
      s.parts.push_back(std::as_const(s.columns).at(as_size(y) * as_size(stride_)));
    }
    kernels().merge_moments(s.parts.data(), &weights_[as_size(first - j + radius_)],
                            static_cast<int>(s.parts.size()), s.sheets.at(as_size(radius_)),
                            stride_);
    // The padding of the row has no weight; the borders in front never had any.
    std::fill(s.sheets.weight.begin() + radius_ + size_[0], s.sheets.weight.end(), 0.0);
  }
  void merge_along_i(MomentBuffers& s) const {
    s.parts.clear();
    for (std::size_t t = 0; t < weights_.size(); ++t) {
      s.parts.push_back(std::as_const(s.sheets).at(t));
    }
    kernels().merge_moments(s.parts.data(), weights_.data(), static_cast<int>(s.parts.size()),
                            s.windows.at(0), stride_);
  }
  void write(const MomentBuffers& s, float* out) const {
    for (std::size_t i = 0; i < as_size(size_[0]); ++i) {
      const double sigma = std::sqrt(s.windows.spread[i] / s.windows.weight[i]);
      const double snr = (s.windows.mean[i] - black_) / std::max(sigma, floor_);
      out[i] = s.row[i] == s.row[i] ? static_cast<float>(snr) : kUnknown;
    }
  }

  const ScalarVolume& volume_;
  std::array<int, 3> size_;
  int radius_;
  int stride_;
  std::vector<double> weights_;
  double black_;
  double floor_;
};

}  // namespace

Result<void> validate(const SnrOptions& options) {
  const int side = options.window_voxels;
  if (!std::isfinite(options.black)) {
    return Error{ErrorCode::kUsage, "signal-to-noise ratio: expected a finite black, found " +
                                        std::to_string(options.black)};
  }
  if (side >= 3 && side <= 31 && side % 2 == 1) return {};
  return Error{ErrorCode::kUsage,
               "signal-to-noise ratio: expected window_voxels odd in [3, 31], "
               "found " +
                   std::to_string(side)};
}

std::vector<double> window_weights(const SnrOptions& options) {
  const int radius = options.window_voxels / 2;
  std::vector<double> weights;
  for (int d = -radius; d <= radius; ++d) {
    const double s = 0.25 * options.window_voxels;
    weights.push_back(
        options.weights == WindowWeights::kUniform ? 1 : std::exp(-0.5 * d * d / (s * s)));
  }
  return weights;
}

Result<FeatureVolume> signal_to_noise(const ScalarVolume& volume, const SnrOptions& options,
                                      const RunOptions& run) {
  if (const auto ok = validate(options); !ok) return ok.error();
  const VoxelGrid& grid = volume.grid();
  const std::string name = volume.name() + ": signal-to-noise ratio";
  constexpr double kBytesPerVoxel = 4.5;
  if (auto ok = check_memory(name, grid.voxel_count(), kBytesPerVoxel, run.memory_limit); !ok) {
    return ok.error();
  }
  std::vector<float> out(grid.voxel_count());
  const SnrPlane plane(volume, options);
  Steps steps(run, as_size(grid.size[2]));
  tbb::enumerable_thread_specific<MomentBuffers> scratch;
  for_each_index(grid.size[2], run.threads, [&](int k) {
    if (steps.next()) plane.run(k, out.data() + offset_of(grid, 0, 0, k), scratch.local());
  });
  if (steps.stopped()) return cancelled(name);
  return FeatureVolume{grid, std::make_shared<const std::vector<float>>(std::move(out))};
}

double windowed(double snr, double low, double high) {
  NAV_CHECK(low < high, low, high);
  return std::isnan(snr) ? snr : std::clamp((snr - low) / (high - low), 0.0, 1.0);
}

}  // namespace nav::render::features
