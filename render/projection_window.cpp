// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/projection_window.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "nav/hounsfield.hpp"
#include "render/default_window.hpp"
#include "render/engine.hpp"

namespace nav::render {
namespace {

/// The values that the rays of a small image find in the volume, in no order.
Result<std::vector<double>> values_found(Scene scene) {
  constexpr int kAcross = 96;
  constexpr double kStepVoxels = 0.25;
  // Holds every 16-bit value, to a hundredth.
  const GreyWindow all{0, 66000};
  scene.plane.reset();
  scene.needle.reset();
  scene.spheres.clear();
  scene.lines.clear();
  scene.cutaway.reset();
  scene.grey = all;
  scene.background_rgb = {1, 0, 0};  // Not grey: marks a ray that misses the volume.
  // The window must not depend on the quality, so the quality is fixed here.
  scene.quality = Quality{};
  scene.quality.step_voxels = kStepVoxels;
  scene.height = std::clamp(kAcross * scene.height / scene.width, 1, kAcross);
  scene.width = kAcross;
  const auto image = make_cpu_engine()->render(scene);
  if (!image) return image.error();
  std::vector<double> values;
  for (const RgbaF& p : image->pixels.pixels()) {
    if (p.r == p.g) values.push_back((p.r - 0.5) * all.width_hu + all.level_hu);
  }
  return values;
}

/// The value below which this share of all values lies.
double quantile(std::vector<double>& values, double share) {
  const double last = static_cast<double>(values.size()) - 1;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::lround(share * last));
  std::ranges::nth_element(values, at);
  return *at;
}

/// Rounds a value to two digits of the unit `by`.
double rounded(double value, double by) {
  const int digits = 1 - static_cast<int>(std::floor(std::log10(by)));
  const double scale = std::pow(10.0, std::abs(digits));
  return digits > 0 ? std::round(value * scale) / scale : std::round(value / scale) * scale;
}

}  // namespace

Result<ProjectionWindow> window_of_projection(Scene scene) {
  NAV_CHECK(scene.projection != Projection::kComposite);
  const bool hounsfield = scene.ct && is_hounsfield(*scene.ct);
  const bool maximum = scene.projection == Projection::kMaximum;
  const double air_below_hu = maximum ? double{kLeastTissueHu} : double{kAirBelowHu};
  // Beside cortical bone and metal, blood with contrast agent would be nearly black.
  constexpr double kWhiteBoneHu = 1000;
  auto values = values_found(std::move(scene));
  if (!values) return values.error();
  ProjectionWindow found;
  if (hounsfield && !values->empty()) {
    std::erase_if(*values, [&](double v) { return v < air_below_hu; });
    found.only_air = values->empty();
  }
  if (found.only_air) {
    found.window = {kLungWindow.level, kLungWindow.width};
    return found;
  }
  if (values->empty()) {
    found.one_value = true;
    return found;
  }
  constexpr double kLeftOut = 0.02;  // A metal implant takes up part of the image.
  constexpr double kSame = 0.05;     // The precision of the values.
  double low = quantile(*values, kLeftOut);
  double high = quantile(*values, 1 - kLeftOut);
  if (hounsfield && maximum && low < kWhiteBoneHu) high = std::min(high, kWhiteBoneHu);
  const auto [least, greatest] = std::ranges::minmax(*values);
  found.one_value = greatest - least < kSame;
  if (high - low < kSame) {
    low = least;
    high = greatest;
  }
  const double width = found.one_value ? 1 : high - low;
  found.window.width_hu = rounded(width, width);
  found.window.level_hu = rounded(0.5 * (low + high), width);
  return found;
}

}  // namespace nav::render
