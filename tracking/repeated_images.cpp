// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/repeated_images.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

namespace nav::tracking {
namespace {

constexpr double kStillMm = 1;
constexpr double kStillRad = std::numbers::pi / 180;

bool same(const Image2d<std::uint8_t>& a, const Image2d<std::uint8_t>& b) {
  return a.width() == b.width() && a.height() == b.height() &&
         std::ranges::equal(a.pixels(), b.pixels());
}

bool of_one_value(const Image2d<std::uint8_t>& image) {
  const auto& pixels = image.pixels();
  return std::ranges::all_of(pixels, [&](std::uint8_t value) { return value == pixels[0]; });
}

}  // namespace

std::string RepeatedImages::doubt(
    const UltrasoundFrame& image,
    const Transform<frames::Tracker, frames::Probe>& tracker_from_probe) {
  if (!first_ || !same(image.pixels, pixels_)) {
    pixels_ = image.pixels;
    first_ = tracker_from_probe;
    since_ = image.acquired;
    said_ = false;
    return {};
  }
  const double mm = (tracker_from_probe.translation_mm() - first_->translation_mm()).norm();
  if (mm <= kStillMm && rotation_distance_rad(tracker_from_probe, *first_) <= kStillRad) return {};
  if (of_one_value(pixels_)) return {};
  const std::string doubt = "the image is unchanged since " + std::to_string(to_seconds(since_)) +
                            " s while the probe moves: the scanner is frozen or repeats images";
  if (!std::exchange(said_, true)) {
    diagnostics_.report("tracking", {.subject = "images",
                                     .key = "pixels",
                                     .values = {doubt},
                                     .used = "these images, as degraded"});
  }
  return doubt;
}

}  // namespace nav::tracking
