// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/vesselness.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <tbb/enumerable_thread_specific.h>

#include "nav/index.hpp"
#include "render/features/filled_field.hpp"
#include "render/features/gaussian_taps.hpp"
#include "render/parallel.hpp"

namespace nav::render::features {
namespace {

/// Buffers of rows of derivatives, with room for the borders on both sides.
struct DerivativeRows {
  std::array<std::vector<float>, 3> planes;  ///< Smooth, slope and bend along k.
  std::array<std::vector<float>, 6> mixed;   ///< Filtered along k and j, one row.
  std::array<std::vector<float>, 6> second;  ///< xx xy yy xz yz zz, one row.
  std::vector<float> best;
  std::vector<const float*> rows;
};

/// Second derivatives and the response of one plane at one scale.
class ScalePlane {
 public:
  ScalePlane(const FilledField& field, const VoxelGrid& grid, double sigma_mm, double truncate,
             const TubeConstants& constants)
      : field_(field), constants_(constants) {
    for (int axis = 0; axis < 3; ++axis) {
      const double sigma = sigma_mm / grid.spacing_mm[axis];
      taps_.emplace_back(gaussian_taps(sigma, truncate), sigma);
    }
  }
  [[nodiscard]] std::array<int, 3> support() const {
    return {taps_[0].radius(), taps_[1].radius(), taps_[2].radius()};
  }
  /// \p best: the plane's greatest responses until now, size[0] x size[1].
  void run(int k, const ActiveBricks& active, float* best, DerivativeRows& s) const {
    allocate(s);
    filter_along_k(k, active, s);
    for (int j = 0; j < field_.size[1]; ++j) {
      if (!active.row(j, k)) continue;
      filter_along_j(j, s);
      filter_along_i(s);
      respond(best + as_size(j) * as_size(field_.size[0]), s);
    }
  }

 private:
  void allocate(DerivativeRows& s) const {
    const std::size_t plane = as_size(field_.stride) * as_size(field_.size[1]);
    for (auto& p : s.planes) p.resize(plane);
    for (auto& m : s.mixed) m.resize(as_size(field_.stride + 2 * taps_[0].radius() + kLanes));
    for (auto& d : s.second) d.resize(as_size(field_.stride));
    s.best.resize(as_size(field_.stride));
  }
  /// True when an active row needs this row of the plane.
  [[nodiscard]] bool needed(int j, int k, const ActiveBricks& active) const {
    const int last = field_.size[1] - 1;
    for (int y = std::max(j - taps_[1].radius(), 0); y <= std::min(j + taps_[1].radius(), last);) {
      if (active.row(y, k)) return true;
      y = (y / 8 + 1) * 8;  // All rows of a brick are alike.
    }
    return false;
  }
  void filter_along_k(int k, const ActiveBricks& active, DerivativeRows& s) const {
    const int radius = taps_[2].radius();
    s.rows.resize(as_size(2 * radius + 1));
    for (int j = 0; j < field_.size[1]; ++j) {
      if (!needed(j, k, active)) continue;
      for (int t = -radius; t <= radius; ++t) {
        s.rows[as_size(t + radius)] = field_.row(j, std::clamp(k + t, 0, field_.size[2] - 1));
      }
      const std::size_t first = as_size(j) * as_size(field_.stride);
      float* const out[3] = {&s.planes[0][first], &s.planes[1][first], &s.planes[2][first]};
      kernels().filter_rows(s.rows.data(), radius, taps_[2].folded(), out, field_.stride);
    }
  }
  void filter_along_j(int j, DerivativeRows& s) const {
    const int radius = taps_[1].radius();
    const std::size_t halo = as_size(taps_[0].radius());
    s.rows.resize(as_size(2 * radius + 1));
    for (int p = 0; p < 3; ++p) {
      for (int t = -radius; t <= radius; ++t) {
        const int y = std::clamp(j + t, 0, field_.size[1] - 1);
        s.rows[as_size(t + radius)] =
            s.planes[as_size(p)].data() + as_size(y) * as_size(field_.stride);
      }
      auto& m = s.mixed;
      float* const all[3][3] = {{&m[0][halo], &m[1][halo], &m[2][halo]},
                                {&m[3][halo], &m[4][halo], nullptr},
                                {&m[5][halo], nullptr, nullptr}};
      kernels().filter_rows(s.rows.data(), radius, taps_[1].folded(), all[p], field_.stride);
    }
  }
  void filter_along_i(DerivativeRows& s) const {
    const int radius = taps_[0].radius();
    s.rows.resize(as_size(2 * radius + 1));
    constexpr int kOrder[6] = {2, 1, 0, 1, 0, 0};  // Order of the derivative along i.
    for (std::size_t m = 0; m < 6; ++m) {
      float* row = s.mixed[m].data() + radius;
      std::fill(s.mixed[m].data(), row, row[0]);
      std::fill(row + field_.size[0], s.mixed[m].data() + s.mixed[m].size(),
                row[field_.size[0] - 1]);
      for (int t = -radius; t <= radius; ++t) s.rows[as_size(t + radius)] = row + t;
      float* out[3] = {nullptr, nullptr, nullptr};
      out[kOrder[m]] = s.second[m].data();
      kernels().filter_rows(s.rows.data(), radius, taps_[0].folded(), out, field_.stride);
    }
  }
  void respond(float* best, DerivativeRows& s) const {
    std::copy_n(best, field_.size[0], s.best.data());
    const HessianRows rows{.xx = s.second[0].data(),
                           .yy = s.second[2].data(),
                           .zz = s.second[5].data(),
                           .xy = s.second[1].data(),
                           .xz = s.second[3].data(),
                           .yz = s.second[4].data()};
    kernels().tube_response(rows, constants_, s.best.data(), field_.stride);
    std::copy_n(s.best.data(), field_.size[0], best);
  }

  const FilledField& field_;
  TubeConstants constants_;
  std::vector<FloatTaps> taps_;
};

TubeConstants constants_of(const VesselnessOptions& options, double contrast) {
  const double c = contrast / (std::numbers::sqrt2 * std::numbers::e);
  const auto half_inverse_square = [](double x) { return static_cast<float>(0.5 / (x * x)); };
  return {half_inverse_square(options.alpha), half_inverse_square(options.beta),
          half_inverse_square(c), options.polarity == Polarity::kBright ? -1.0F : 1.0F};
}

/// Range of values below which no response exceeds the negligible one. For data within a range W, a
/// second derivative is at most W / 2 times the integral of the kernel's magnitude. So
/// S^2 <= 1.31 W^2, and the response is at most S^2 / (2 c^2).
double harmless_range(const VesselnessOptions& options, double contrast) {
  const double c = contrast / (std::numbers::sqrt2 * std::numbers::e);
  constexpr double kSlack = 1.5;  // Margin for sampled kernels with few taps.
  return c * std::sqrt(2 * options.negligible_response / (1.31 * kSlack));
}

void mark_unknown(const ScalarVolume& volume, std::vector<float>& values, int threads) {
  const auto& grid = volume.grid();
  for_each_index(grid.size[2], threads, [&](int k) {
    std::vector<float> row(as_size(grid.size[0]));
    for (int j = 0; j < grid.size[1]; ++j) {
      volume.read_row(j, k, row.data());
      float* out = values.data() + offset_of(grid, 0, j, k);
      for (std::size_t i = 0; i < row.size(); ++i) out[i] = row[i] == row[i] ? out[i] : kUnknown;
    }
  });
}

}  // namespace

Result<void> validate(const VesselnessOptions& options) {
  struct Range {
    const char* name;
    double value, low, high;
  };
  const Range ranges[] = {
      {"smallest_radius_mm", options.smallest_radius_mm, 1e-3, 100},
      {"largest_radius_mm", options.largest_radius_mm, options.smallest_radius_mm, 100},
      {"scales", static_cast<double>(options.scales), 1, 16},
      {"alpha", options.alpha, 1e-3, 1e3},
      {"beta", options.beta, 1e-3, 1e3},
      {"contrast", options.contrast, 0, 1e9},
      {"truncate", options.truncate, 2, 8},
      {"negligible_response", options.negligible_response, 0, 0.1},
  };
  for (const Range& r : ranges) {
    if (r.value >= r.low && r.value <= r.high) continue;
    std::ostringstream text;
    text << "vesselness: expected " << r.name << " in [" << r.low << ", " << r.high << "], found "
         << r.value;
    return Error{ErrorCode::kUsage, text.str()};
  }
  return {};
}

std::vector<double> sigmas_mm(const VesselnessOptions& options) {
  const double first = options.smallest_radius_mm / std::numbers::sqrt2;
  const double last = options.largest_radius_mm / std::numbers::sqrt2;
  if (options.scales == 1) return {std::sqrt(first * last)};
  std::vector<double> sigmas;
  for (int s = 0; s < options.scales; ++s) {
    sigmas.push_back(first * std::pow(last / first, s / (options.scales - 1.0)));
  }
  return sigmas;
}

double contrast_of(const VesselnessOptions& options, const ScalarVolume& volume, int threads) {
  if (options.contrast > 0) return options.contrast;
  const ValueRange range = value_range(volume, 0.01, 0.99, threads);
  const double contrast = 0.5 * (range.high - range.low);
  if (contrast > 0) return contrast;
  // Almost all voxels are equal, so the contrast comes from the few others.
  const double whole = 0.5 * (range.greatest - range.least);
  return whole > 0 ? whole : 1;
}

Result<void> validate(const VesselnessOptions& options, const VoxelGrid& grid,
                      const std::string& name) {
  if (const auto ok = validate(options); !ok) return ok;
  const FilterReach widest{"largest_radius_mm", options.largest_radius_mm,
                           sigmas_mm(options).back(), options.truncate};
  return check_reach(widest, grid, name + ": vesselness");
}

Result<FeatureVolume> vesselness(const ScalarVolume& volume, const VesselnessOptions& options,
                                 const RunOptions& run) {
  const VoxelGrid& grid = volume.grid();
  if (const auto ok = validate(options, grid, volume.name()); !ok) return ok.error();
  const std::string name = volume.name() + ": vesselness";
  constexpr double kBytesPerVoxel = 14;
  if (auto ok = check_memory(name, grid.voxel_count(), kBytesPerVoxel, run.memory_limit); !ok) {
    return ok.error();
  }
  const auto sigmas = sigmas_mm(options);
  const double contrast = contrast_of(options, volume, run.threads);
  const TubeConstants constants = constants_of(options, contrast);
  const double coarsest = sigmas.back() / grid.spacing_mm.minCoeff();
  const FilledField field =
      filled_field(volume, gaussian_taps(coarsest, options.truncate).radius, run.threads);
  std::vector<float> best(grid.voxel_count(), 0.0F);
  Steps steps(run, sigmas.size() * as_size(grid.size[2]));
  tbb::enumerable_thread_specific<DerivativeRows> scratch;
  for (const double sigma : sigmas) {
    const ScalePlane plane(field, grid, sigma, options.truncate, constants);
    const ActiveBricks active(field, plane.support(), harmless_range(options, contrast),
                              run.threads);
    for_each_index(grid.size[2], run.threads, [&](int k) {
      if (!steps.next()) return;
      plane.run(k, active, best.data() + offset_of(grid, 0, 0, k), scratch.local());
    });
    if (steps.stopped()) return cancelled(name);
  }
  if (!field.all_known) mark_unknown(volume, best, run.threads);
  return FeatureVolume{grid, std::make_shared<const std::vector<float>>(std::move(best))};
}

}  // namespace nav::render::features
