// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/detail/hu_builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "io/detail/text.hpp"
#include "nav/matrices.hpp"

namespace nav::io::detail {

void HuBuilder::note_below(double hu) {
  least_below_ = std::min(least_below_, hu);
  if (different_below_.size() > kMostPaddings) return;
  if (std::ranges::find(different_below_, hu) == different_below_.end()) {
    different_below_.push_back(hu);
  }
}

bool HuBuilder::lost_values() const {
  if (ct_) return false;
  if (floor_ != kAirHu) return true;
  // Scanners produce noise slightly below air, and resampling mixes padding into its neighbours.
  constexpr double kNoiseHu = 500;
  constexpr double kMostShare = 0.02;
  return different_below_.size() > kMostPaddings &&
         least_below_<kAirHu - kNoiseHu&& static_cast<double>(below_)> kMostShare *
             static_cast<double>(hu_.size());
}

void HuBuilder::push(double hu) {
  constexpr double kMax = std::numeric_limits<std::int16_t>::max();
  if (!std::isfinite(hu)) {
    if (not_finite_++ == 0) first_not_finite_ = hu_.size();
    hu_.push_back(kAirHu);
    return;
  }
  double rounded = std::nearbyint(hu);
  fractions_ |= rounded != hu;
  least_ = std::min(least_, hu);
  greatest_ = std::max(greatest_, hu);
  if (rounded < floor_) {
    ++below_;
    note_below(rounded);
    rounded = floor_;
  } else if (rounded > kMax) {
    ++above_;
    rounded = kMax;
  }
  hu_.push_back(static_cast<std::int16_t>(rounded));
}

/// Fast path of append() for 16-bit integers that need no rounding: most CTs.
template <class T>
void HuBuilder::append_shifted(std::span<const std::byte> samples, std::int32_t by) {
  constexpr std::int32_t kMax = std::numeric_limits<std::int16_t>::max();
  constexpr std::size_t kBlock = 1024;
  const std::int32_t least = floor_;
  std::array<std::int16_t, kBlock> block;
  for (std::size_t left = samples.size() / sizeof(T); left > 0;) {
    const std::size_t count = std::min(left, kBlock);
    std::int32_t below = 0;
    std::int32_t above = 0;
    for (std::size_t i = 0; i < count; ++i) {
      T stored;
      std::memcpy(&stored, samples.data() + i * sizeof(T), sizeof(T));
      const std::int32_t hu = stored + by;
      below += hu < least ? 1 : 0;
      above += hu > kMax ? 1 : 0;
      block[i] = static_cast<std::int16_t>(std::clamp<std::int32_t>(hu, least, kMax));
    }
    for (std::size_t i = 0; below > 0 && i < count; ++i) {
      T stored;
      std::memcpy(&stored, samples.data() + i * sizeof(T), sizeof(T));
      if (stored + by < least) note_below(stored + by);
    }
    below_ += static_cast<std::size_t>(below);
    above_ += static_cast<std::size_t>(above);
    hu_.insert(hu_.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(count));
    samples = samples.subspan(count * sizeof(T));
    left -= count;
  }
}

void HuBuilder::append(std::span<const std::byte> samples, PixelType type, const Rescale& rescale) {
  constexpr double kFarthest = 1e6;
  if (rescale.slope == 1 && !rescale.padding && std::abs(rescale.intercept) <= kFarthest &&
      rescale.intercept == std::trunc(rescale.intercept)) {
    const auto by = static_cast<std::int32_t>(rescale.intercept);
    if (type == PixelType::kInt16) return append_shifted<std::int16_t>(samples, by);
    if (type == PixelType::kUint16) return append_shifted<std::uint16_t>(samples, by);
  }
  for_each_sample(samples, type, [&](auto stored) {
    const auto value = static_cast<double>(stored);
    if (rescale.padding && value >= rescale.padding->first && value <= rescale.padding->second) {
      ++padded_;
      hu_.push_back(kAirHu);
    } else {
      push(rescale.slope * value + rescale.intercept);
    }
  });
}

Result<void> HuBuilder::report(const std::string& name, const std::array<int, 3>& size,
                               const std::string& unit, Diagnostics& diagnostics) const {
  if (not_finite_ > 0) {
    const auto row = static_cast<std::size_t>(size[0]);
    const std::size_t slice = row * static_cast<std::size_t>(size[1]);
    const std::size_t i = first_not_finite_;
    return Error{ErrorCode::kMalformedData,
                 name + ": expected finite voxels, found " + std::to_string(not_finite_) +
                     " NaN or Inf, the first at index (" + std::to_string(i % row) + ", " +
                     std::to_string(i % slice / row) + ", " + std::to_string(i / slice) + ")"};
  }
  const double span = greatest_ - least_;
  if (fractions_ && span > 0 && span < kLeastSpan) {
    // The factor gives as many steps as 10 to 13 bits have.
    const double factor = std::pow(10, std::ceil(std::log10(1000 / span)));
    return Error{
        ErrorCode::kUnsupportedData,
        name +
            ": expected voxels that can be rounded to whole numbers, found fractions from only " +
            to_text(least_) + " to " + to_text(greatest_) + ": multiply them by " +
            to_text(factor) + ", and every option that is in their unit"};
  }
  const auto say = [&](Severity severity, std::size_t count, const std::string& what) {
    if (count > 0) {
      diagnostics.report(severity, "io.ct",
                         name + ": " + std::to_string(count) + " voxels " + what);
    }
  };
  const std::string of_unit = unit.empty() ? "" : " " + unit;
  const std::string air = std::to_string(kAirHu) + of_unit;
  const std::string least = std::to_string(floor_) + of_unit;
  const std::string most = "32767" + of_unit;
  say(Severity::kInfo, padded_, "of padding set to " + air);
  // Noise and interpolation below air, and padding of a few values, as most scanners write, are no
  // loss.
  constexpr double kNoise = 300;
  if (below_ > 0) {
    const bool usual = least_below_ >= floor_ - kNoise || different_below_.size() <= kMostPaddings;
    diagnostics.report(
        "io.ct",
        {.subject = name,
         .key = "values below " + least,
         .values = {std::to_string(below_) + " voxels, down to " + to_text(least_below_) + of_unit +
                    (lost_values() && floor_ == kAirHu
                         ? " (if this is not a CT, add a constant to all voxels)"
                         : "")},
         .used = least,
         .severity = usual && !lost_values() ? Severity::kInfo : Severity::kWarning});
  }
  say(Severity::kWarning, above_, "above " + most + " set to " + most);
  return {};
}

Result<StoredVolume> HuBuilder::finish(const VoxelGrid& grid, const std::string& name,
                                       const std::string& unit, Diagnostics& diagnostics) && {
  if (const auto ok = report(name, grid.size, unit, diagnostics); !ok) return ok.error();
  return StoredVolume::create(grid, std::move(hu_), name);
}

Result<VoxelGrid> grid_from_affine(const std::array<int, 3>& size,
                                   const Eigen::Matrix<double, 3, 4>& ct_from_index,
                                   const std::string& name) {
  constexpr double kMaxShear = 1e-3;
  constexpr double kExact = 1e-9;  // Below: the numbers of the file are kept.
  VoxelGrid grid;
  grid.size = size;
  grid.origin_mm = ct_from_index.col(3);
  for (int axis = 0; axis < 3; ++axis) {
    const double length = ct_from_index.col(axis).norm();
    if (!std::isfinite(length) || length <= 0) {
      return Error{ErrorCode::kMalformedData, name +
                                                  ": expected a positive spacing in mm along "
                                                  "axis " +
                                                  std::to_string(axis) + ", found " +
                                                  to_text(length)};
    }
    grid.spacing_mm[axis] = length;
    grid.directions.col(axis) = ct_from_index.col(axis) / length;
  }
  grid.directions.array() += 0.0;  // Removes negative zeros from reports.
  const Eigen::Matrix3d& d = grid.directions;
  const double shear = (d.transpose() * d - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(shear <= kMaxShear)) {
    return Error{ErrorCode::kUnsupportedData,
                 name + ": expected orthogonal axes, found cosines up to " + to_text(shear) +
                     " between them (a sheared, tilted stack)"};
  }
  if (shear > kExact) {
    grid.directions = nearest_orthogonal(d);
  }
  if (const auto ok = validate(grid, name); !ok) return ok.error();
  return grid;
}

}  // namespace nav::io::detail
