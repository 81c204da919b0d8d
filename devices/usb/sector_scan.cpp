// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/sector_scan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "nav/check.hpp"

namespace nav::devices {
namespace {

constexpr int kMostSectorPixels = 4096;

double half_angle_of(const SectorShape& shape) {
  return shape.angle_deg / 2 * std::numbers::pi / 180;
}

/// Pixels across and down.
std::pair<double, double> size_of(const SectorShape& shape) {
  const double half = half_angle_of(shape);
  const double furthest = shape.radius_mm + shape.depth_mm;
  return {2 * furthest * std::sin(half) / shape.spacing_mm + 1,
          (furthest - shape.radius_mm * std::cos(half)) / shape.spacing_mm + 1};
}

}  // namespace

Result<void> validate(const SectorShape& shape) {
  struct Bound {
    const char* key;
    double value, low, high;
    const char* expected;
  };
  for (const Bound& one : {Bound{"radius_mm", shape.radius_mm, 0, 200, "0 to 200 mm"},
                           {"depth_mm", shape.depth_mm, 1, 500, "1 to 500 mm"},
                           {"angle_deg", shape.angle_deg, 1, 170, "1 to 170 degrees"},
                           {"spacing_mm", shape.spacing_mm, 0.05, 2, "0.05 to 2 mm"}}) {
    if (one.value >= one.low && one.value <= one.high) continue;
    return Error{ErrorCode::kUsage, std::string("sector: expected ") + one.expected + " for " +
                                        one.key + ", found " + std::to_string(one.value)};
  }
  const auto [width, height] = size_of(shape);
  if (std::max(width, height) <= kMostSectorPixels) return {};
  return Error{ErrorCode::kUsage, "sector: expected at most 4096 pixels a side, found " +
                                      std::to_string(static_cast<int>(width)) + " x " +
                                      std::to_string(static_cast<int>(height)) +
                                      "; a larger spacing_mm makes fewer"};
}

SectorScan::SectorScan(const SectorShape& shape, std::size_t lines, std::size_t samples)
    : lines_(lines), samples_(samples) {
  NAV_CHECK(validate(shape).has_value() && lines >= 2 && samples >= 2, lines, samples);
  const double half = half_angle_of(shape);
  const auto [width, height] = size_of(shape);
  // An odd number of columns has one in the middle.
  width_ = static_cast<int>(std::ceil(width)) | 1;
  height_ = static_cast<int>(std::ceil(height));
  grid_ = PixelGrid::centred(width_, shape.spacing_mm, shape.spacing_mm);
  outline_ = {.apex_mm = {0, -shape.radius_mm * std::cos(half)},
              .radius_min_mm = shape.radius_mm,
              .radius_max_mm = shape.radius_mm + shape.depth_mm,
              .half_angle_rad = half};
  const double last_line = static_cast<double>(lines - 1);
  const double last_sample = static_cast<double>(samples - 1);
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < width_; ++column) {
      const double x = (column - width_ / 2) * shape.spacing_mm - outline_.apex_mm.x();
      const double y = row * shape.spacing_mm - outline_.apex_mm.y();
      const double line = (std::atan2(x, y) + half) / (2 * half) * last_line;
      const double sample = (std::hypot(x, y) - shape.radius_mm) / shape.depth_mm * last_sample;
      // Rounding must not lose the pixels at the edge.
      constexpr double kEdge = 1e-9;
      if (!(line >= -kEdge && line <= last_line + kEdge && sample >= -kEdge &&
            sample <= last_sample + kEdge)) {
        continue;
      }
      const double first_line = std::clamp(std::floor(line), 0.0, last_line - 1);
      const double first_sample = std::clamp(std::floor(sample), 0.0, last_sample - 1);
      sources_.push_back(
          {.pixel = static_cast<std::uint32_t>(row * width_ + column),
           .sample =
               static_cast<std::uint32_t>(first_line * static_cast<double>(samples) + first_sample),
           .across = static_cast<float>(std::clamp(line - first_line, 0.0, 1.0)),
           .along = static_cast<float>(std::clamp(sample - first_sample, 0.0, 1.0))});
    }
  }
}

Image2d<std::uint8_t> SectorScan::convert(std::span<const std::uint8_t> samples) const {
  NAV_CHECK(samples.size() == lines_ * samples_, samples.size(), lines_, samples_);
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width_) *
                                   static_cast<std::size_t>(height_));
  for (const Source& source : sources_) {
    const std::uint8_t* const first = samples.data() + source.sample;
    const std::uint8_t* const second = first + samples_;
    const auto between = [&](const std::uint8_t* line) {
      const float near = line[0], far = line[1];
      return near + source.along * (far - near);
    };
    const float left = between(first), right = between(second);
    pixels[source.pixel] =
        static_cast<std::uint8_t>(std::lround(left + source.across * (right - left)));
  }
  return {width_, height_, std::move(pixels)};
}

}  // namespace nav::devices
