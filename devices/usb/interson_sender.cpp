// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/interson_sender.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace nav::devices {

EmulatedSector sector_of(const UltrasoundImage& image) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  EmulatedSector sector;
  sector.shape.spacing_mm = std::clamp(image.grid.mm_per_pixel(0, 0), 0.05, 2.0);
  if (image.outline) {
    const SectorOutline& outline = *image.outline;
    sector.shape.radius_mm = outline.radius_min_mm;
    sector.shape.depth_mm = outline.radius_max_mm - outline.radius_min_mm;
    sector.shape.angle_deg = 2 * outline.half_angle_rad * kDegrees;
    sector.apex_mm = outline.apex_mm;
    return sector;
  }
  constexpr double kRadiusMm = 60, kMostSine = 0.8;
  const auto [low, high] = box_mm(image);
  const double half = std::asin(std::clamp((high.x() - low.x()) / 2 / kRadiusMm, 0.1, kMostSine));
  sector.shape.radius_mm = kRadiusMm;
  sector.shape.depth_mm = std::clamp(high.y() - low.y(), 1.0, 500.0);
  sector.shape.angle_deg = 2 * half * kDegrees;
  sector.apex_mm = {(low.x() + high.x()) / 2, low.y() - kRadiusMm * std::cos(half)};
  return sector;
}

IntersonLines scan_lines_of(const UltrasoundImage& image, const EmulatedSector& sector) {
  IntersonLines lines(kIntersonLines * kIntersonSamples);
  const double half = sector.shape.angle_deg / 2 * std::numbers::pi / 180;
  for (std::size_t line = 0; line < kIntersonLines; ++line) {
    const double angle = half * (2 * static_cast<double>(line) / (kIntersonLines - 1) - 1);
    const Eigen::Vector2d direction(std::sin(angle), std::cos(angle));
    for (std::size_t sample = 0; sample < kIntersonSamples; ++sample) {
      const double radius = sector.shape.radius_mm + sector.shape.depth_mm *
                                                         static_cast<double>(sample) /
                                                         (kIntersonSamples - 1);
      const Eigen::Vector2d at = sector.apex_mm + radius * direction;
      const Eigen::Vector2d pixel =
          image.grid.pixel_of(Point<frames::Image>{Eigen::Vector3d(at.x(), at.y(), 0)});
      const double column = std::round(pixel.x()), row = std::round(pixel.y());
      if (!(column >= 0 && row >= 0 && column < image.pixels.width() &&
            row < image.pixels.height())) {
        continue;
      }
      lines[line * kIntersonSamples + sample] =
          image.pixels.at(static_cast<int>(column), static_cast<int>(row));
    }
  }
  return lines;
}

Result<std::unique_ptr<IntersonSender>> IntersonSender::start(IntersonFaultPlan plan,
                                                              const std::string& address,
                                                              std::uint16_t port) {
  std::unique_ptr<IntersonSender> sender(new IntersonSender());
  auto emulator = IntersonEmulator::start(
      {.see = [&it = *sender](std::uint64_t /*image*/) { return it.see(); }}, std::move(plan),
      address, port);
  if (!emulator) return emulator.error();
  sender->emulator_ = *std::move(emulator);
  return sender;
}

std::optional<IntersonLines> IntersonSender::see() {
  const std::lock_guard lock(mutex_);
  return std::exchange(newest_, std::nullopt);
}

std::optional<EmulatedSector> IntersonSender::send(const Sample& sample) {
  const auto* const image = std::get_if<UltrasoundImage>(&sample.what);
  if (image == nullptr) return std::nullopt;
  const bool first = !sector_;
  if (first) sector_ = sector_of(*image);
  IntersonLines lines = scan_lines_of(*image, *sector_);
  {
    const std::lock_guard lock(mutex_);
    newest_ = std::move(lines);
  }
  return first ? sector_ : std::nullopt;
}

}  // namespace nav::devices
