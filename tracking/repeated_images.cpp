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

std::optional<RepeatedImage> RepeatedImages::find(
    const UltrasoundImage& image,
    const Transform<frames::Tracker, frames::Probe>& tracker_from_probe) {
  const auto first =
      std::ranges::find_if(kept_, [&](const First& one) { return same(image.pixels, one.pixels); });
  if (first == kept_.end()) {
    if (kept_.size() == kMostKept) kept_.pop_back();
    kept_.push_front({image.pixels, tracker_from_probe, image.acquired});
    last_ = 0;
    return std::nullopt;
  }
  const std::ptrdiff_t before = std::exchange(last_, first - kept_.begin());
  const double mm =
      (tracker_from_probe.translation_mm() - first->tracker_from_probe.translation_mm()).norm();
  const double rad = rotation_distance_rad(tracker_from_probe, first->tracker_from_probe);
  if (mm <= kStillMm && rad <= kStillRad) return std::nullopt;
  if (of_one_value(first->pixels)) return std::nullopt;
  const std::string since = std::to_string(to_seconds(first->acquired)) + " s ";
  const std::string doubt =
      before == last_
          ? "the image is unchanged since " + since +
                "while the probe moves: the scanner is frozen or repeats images"
          : "the image is again that of " + since +
                "while the probe moves: the scanner or the frame grabber alternates between images";
  if (!std::exchange(first->said, true)) {
    diagnostics_.report("tracking",
                        {.subject = "images",
                         .key = "pixels",
                         .values = {doubt},
                         .used = "these images, as degraded, and as stale once they are old"});
  }
  return RepeatedImage{doubt, first->acquired};
}

}  // namespace nav::tracking
