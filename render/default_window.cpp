// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/default_window.hpp"

#include <algorithm>
#include <cmath>

#include "nav/hounsfield.hpp"
#include "render/transfer/transfer_presets.hpp"

namespace nav::render {
namespace {

constexpr HuWindow kVesselWindow{200, 700};
constexpr HuWindow kSoftTissueWindow{60, 400};

/// A window from the darkest to the brightest value. Tissue below the lower end of value_range() is
/// not black.
HuWindow window_of_values(const StoredVolume& volume) {
  constexpr std::size_t kHundredth = 100;
  std::vector<std::int16_t> voxels(volume.values().begin(), volume.values().end());
  const auto darkest = voxels.begin() + static_cast<std::ptrdiff_t>(voxels.size() / kHundredth);
  std::ranges::nth_element(voxels, darkest);
  const double high = std::max(value_range(volume).high, *darkest + 1.0);
  const double width = high - *darkest;
  const double level = 0.5 * (*darkest + high);
  // A whole number is easier to read. Rounding would shift a narrow window (of a mask).
  constexpr double kNarrow = 20;
  return {width < kNarrow ? level : std::round(level), width};
}

}  // namespace

HuWindow default_window(const StoredVolume& volume, std::span<const float> shown) {
  if (!is_hounsfield(volume)) return window_of_values(volume);
  constexpr float kLungBelowHu = -500;
  constexpr double kWhiteHu = kSoftTissueWindow.level + kSoftTissueWindow.width / 2;
  const auto count = [&](auto of) { return std::ranges::count_if(shown, of); };
  const auto body = count([](float v) { return v > kAirBelowHu; });
  const auto lung = count([](float v) { return v > kAirBelowHu && v < kLungBelowHu; });
  if (2 * lung > body) return kLungWindow;
  const auto tissue = count([](float v) { return v > kLeastTissueHu; });
  const auto white = count([](float v) { return v > kWhiteHu; });
  return white > 0 && 5 * white >= tissue ? kVesselWindow : kSoftTissueWindow;
}

}  // namespace nav::render
