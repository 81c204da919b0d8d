// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/ct_scanner.hpp"

#include <cmath>
#include <sstream>
#include <string>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "sim/blur.hpp"
#include "sim/random.hpp"

namespace nav::sim {
namespace {

constexpr std::uint64_t kNoiseStream = 0x6374;
constexpr double kMinHu = -1024;
constexpr double kMaxHu = 3071;

template <class Found>
Error rejected_scan(const std::string& expected, const Found& found) {
  std::ostringstream text;
  text << "simulated CT: expected " << expected << ", found " << found;
  return Error{ErrorCode::kUsage, text.str()};
}

Result<void> check_settings(const CtOptions& options) {
  if (!(options.noise_hu >= 0) || !std::isfinite(options.noise_hu)) {
    return rejected_scan("noise >= 0 HU", options.noise_hu);
  }
  if (!(options.psf_mm >= 0 && options.psf_mm <= 20)) {
    return rejected_scan("a blur of 0 to 20 mm", options.psf_mm);
  }
  if (options.points_per_axis < 1 || options.points_per_axis > 8) {
    return rejected_scan("1 to 8 points per axis", options.points_per_axis);
  }
  return {};
}

Result<VoxelGrid> grid_of(const CtOptions& options) {
  VoxelGrid grid;
  for (int axis = 0; axis < 3; ++axis) {
    const double spacing = options.spacing_mm[axis];
    const double length = options.region.max_mm[axis] - options.region.min_mm[axis];
    if (!(spacing > 0 && std::isfinite(spacing))) return rejected_scan("spacing > 0 mm", spacing);
    if (!(length > 0 && length < 1e4)) return rejected_scan("a region of 0 to 10^4 mm", length);
    const double count = length / spacing;
    if (count >= 1e6) return rejected_scan("at most 10^6 voxels along an axis", count);
    // Rounding must not drop the last voxel of a region that is a multiple of the spacing.
    grid.size[static_cast<std::size_t>(axis)] = static_cast<int>(count + 1e-6) + 1;
  }
  grid.spacing_mm = options.spacing_mm;
  grid.origin_mm = options.region.min_mm;
  return grid;
}

/// Mean over the points of a voxel.
double voxel_value(const Anatomy& patient, const VoxelGrid& grid, const Eigen::Vector3d& index,
                   int points) {
  if (points == 1) return patient.hu(grid.at(index));
  double sum = 0;
  for (int i = 0; i < points * points * points; ++i) {
    const Eigen::Vector3d step(i % points, (i / points) % points, i / (points * points));
    sum += patient.hu(grid.at(index + ((step.array() + 0.5) / points - 0.5).matrix()));
  }
  return sum / (points * points * points);
}

}  // namespace

CtRegion region_of(const Anatomy& patient) {
  const Eigen::AlignedBox3d box = patient.region_mm();
  return {box.min(), box.max()};
}

Result<Volume> scan_ct(const Anatomy& patient, const CtOptions& options) {
  if (const auto ok = check_settings(options); !ok) return ok.error();
  const auto grid = grid_of(options);
  if (!grid) return grid.error();
  return scan_ct(patient, *grid, options);
}

Result<Volume> scan_ct(const Anatomy& patient, const VoxelGrid& grid, const CtOptions& options) {
  if (const auto ok = check_settings(options); !ok) return ok.error();
  if (const auto ok = validate(grid, "simulated CT"); !ok) return ok.error();
  const auto nx = static_cast<std::size_t>(grid.size[0]);
  const auto ny = static_cast<std::size_t>(grid.size[1]);
  const auto nz = static_cast<std::size_t>(grid.size[2]);
  std::vector<float> clean(grid.voxel_count());
  const auto rows = tbb::blocked_range<std::size_t>(0, ny * nz);
  tbb::parallel_for(rows, [&](const auto& range) {
    for (std::size_t row = range.begin(); row != range.end(); ++row) {
      for (std::size_t i = 0; i < nx; ++i) {
        const Eigen::Vector3d index(static_cast<double>(i), static_cast<double>(row % ny),
                                    static_cast<double>(row / ny));
        clean[row * nx + i] =
            static_cast<float>(voxel_value(patient, grid, index, options.points_per_axis));
      }
    }
  });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    blur_axis(clean, grid, axis, options.psf_mm / grid.spacing_mm[static_cast<int>(axis)]);
  }
  std::vector<std::int16_t> hu(clean.size());
  tbb::parallel_for(rows, [&](const auto& range) {
    for (std::size_t v = range.begin() * nx; v != range.end() * nx; ++v) {
      double value = clean[v];
      if (options.noise_hu > 0)
        value += options.noise_hu * normal_at(options.seed, kNoiseStream, v);
      hu[v] = static_cast<std::int16_t>(std::lround(std::clamp(value, kMinHu, kMaxHu)));
    }
  });
  return Volume::create(grid, std::move(hu), patient.name());
}

}  // namespace nav::sim
