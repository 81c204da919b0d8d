// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/feature.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nav::render {
namespace {

constexpr double kMostCode = 32767;
/// Relative spacing of single-precision numbers: the step of values of size 1.
constexpr double kSinglePrecision = std::numeric_limits<float>::epsilon();
/// Step for a constant 0: far below any value that matters, and a normal number in single
/// precision.
constexpr double kLeastStep = 1e-30;

Result<void> check_count(const VoxelGrid& grid, std::size_t count, const std::string& name) {
  if (const auto ok = validate(grid, name); !ok) return ok.error();
  if (count == grid.voxel_count()) return {};
  return Error{ErrorCode::kMalformedData, name + ": expected " +
                                              std::to_string(grid.voxel_count()) +
                                              " voxels, found " + std::to_string(count)};
}

}  // namespace

Result<FeatureVolume> FeatureVolume::create(const VoxelGrid& grid, std::span<const float> values,
                                            std::string name) {
  if (const auto ok = check_count(grid, values.size(), name); !ok) return ok.error();
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const float v : values) {
    if (!std::isfinite(v)) continue;
    low = std::min<double>(low, v);
    high = std::max<double>(high, v);
  }
  FeatureVolume out;
  // A single value is stored exactly, with a step that separates it from any other number.
  out.offset_ = low <= high ? 0.5 * (low + high) : 0;
  const double greatest = low <= high ? std::max(std::abs(low), std::abs(high)) : 0;
  const double step = std::max(kSinglePrecision * greatest, kLeastStep);
  out.scale_ = low < high ? 0.5 * (high - low) / kMostCode : step;
  out.quantum_ = std::max(out.scale_, step);
  std::vector<std::int16_t> codes(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool defined = std::isfinite(values[i]);
    out.has_undefined_ = out.has_undefined_ || !defined;
    const double code = defined ? std::round((values[i] - out.offset_) / out.scale_) : 0;
    codes[i] =
        defined ? static_cast<std::int16_t>(std::clamp(code, -kMostCode, kMostCode)) : kUndefined;
  }
  auto volume = StoredVolume::create(grid, std::move(codes), std::move(name));
  if (!volume) return volume.error();
  out.codes_ = std::make_shared<const StoredVolume>(*std::move(volume));
  return out;
}

Result<LabelVolume> LabelVolume::create(const VoxelGrid& grid, std::vector<std::uint32_t> bits,
                                        std::string name) {
  auto voxels = Voxels::create(grid, std::move(bits), std::move(name));
  if (!voxels) return voxels.error();
  return LabelVolume(*std::move(voxels));
}

}  // namespace nav::render
