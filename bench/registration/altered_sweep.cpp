// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/altered_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "nav/check.hpp"
#include "sim/random.hpp"

namespace nav::bench {
namespace {

using ReferenceFromImage = Transform<frames::Reference, frames::Image>;

Sweep sweep_of(std::vector<TrackedImage> frames, const Sweep& like) {
  return std::move(Sweep::create(std::move(frames), like.calibration_id())).value();
}

/// True position of the echo drawn at p, if depths along the beam are drawn factor times as large.
Eigen::Vector2d source_of(const Eigen::Vector2d& p, const std::optional<SectorOutline>& outline,
                          double factor) {
  if (!outline) return {p.x(), p.y() / factor};
  const Eigen::Vector2d from_apex = p - outline->apex_mm;
  const double depth_mm = from_apex.norm() - outline->radius_min_mm;
  return outline->apex_mm + (outline->radius_min_mm + depth_mm / factor) * from_apex.normalized();
}

/// Bilinear; black outside the image and its outline.
std::uint8_t grey_at(const UltrasoundImage& frame, const Eigen::Vector2d& p) {
  if (frame.outline && !frame.outline->contains(p)) return 0;
  const Eigen::Vector2d at = frame.grid.pixel_of({{p.x(), p.y(), 0}});
  const auto& pixels = frame.pixels;
  const Eigen::Vector2d last(pixels.width() - 1, pixels.height() - 1);
  if (!(at.array() >= 0).all() || !(at.array() <= last.array()).all()) return 0;
  const int column = std::min(static_cast<int>(at.x()), pixels.width() - 2);
  const int row = std::min(static_cast<int>(at.y()), pixels.height() - 2);
  const double right = at.x() - column;
  const double down = at.y() - row;
  const double upper = (1 - right) * pixels.at(column, row) + right * pixels.at(column + 1, row);
  const double lower =
      (1 - right) * pixels.at(column, row + 1) + right * pixels.at(column + 1, row + 1);
  return static_cast<std::uint8_t>(std::lround((1 - down) * upper + down * lower));
}

/// Interpolates the sweep's poses; absent before the first and after the last.
std::optional<ReferenceFromImage> pose_at(const Sweep& sweep, Timestamp time) {
  const auto& frames = sweep.frames();
  const auto after = std::ranges::lower_bound(
      frames, time, {}, [](const TrackedImage& tracked) { return tracked.frame.acquired; });
  if (after == frames.end()) return {};
  if (after->frame.acquired == time) return after->reference_from_image;
  if (after == frames.begin()) return {};
  const TrackedImage& before = *std::prev(after);
  const double share = to_seconds(time - before.frame.acquired) /
                       to_seconds(after->frame.acquired - before.frame.acquired);
  return interpolate(before.reference_from_image, after->reference_from_image, share);
}

/// Moves the images relative to the probe.
Sweep held_elsewhere(const Sweep& sweep, const Transform<frames::Image, frames::Image>& error) {
  std::vector<TrackedImage> frames = sweep.frames();
  for (TrackedImage& tracked : frames) {
    tracked.reference_from_image = tracked.reference_from_image * error;
  }
  return sweep_of(std::move(frames), sweep);
}

}  // namespace

Sweep with_pixels(
    const Sweep& sweep,
    const std::function<void(std::vector<std::uint8_t>&, const UltrasoundImage&)>& change) {
  std::vector<TrackedImage> frames = sweep.frames();
  for (TrackedImage& tracked : frames) {
    const auto old = tracked.frame.pixels.pixels();
    std::vector<std::uint8_t> pixels(old.begin(), old.end());
    change(pixels, tracked.frame);
    tracked.frame.pixels = Image2d<std::uint8_t>(tracked.frame.pixels.width(),
                                                 tracked.frame.pixels.height(), std::move(pixels));
  }
  return sweep_of(std::move(frames), sweep);
}

Sweep enlarged(const Sweep& sweep, double factor) {
  NAV_CHECK(factor > 0, factor);
  std::vector<TrackedImage> frames = sweep.frames();
  for (TrackedImage& tracked : frames) {
    tracked.frame.grid.mm_per_pixel *= factor;
    tracked.frame.grid.origin_mm *= factor;
    if (!tracked.frame.outline) continue;
    tracked.frame.outline->apex_mm *= factor;
    tracked.frame.outline->radius_min_mm *= factor;
    tracked.frame.outline->radius_max_mm *= factor;
  }
  return sweep_of(std::move(frames), sweep);
}

Sweep deepened(const Sweep& sweep, double factor) {
  NAV_CHECK(factor > 0, factor);
  std::vector<TrackedImage> frames =
      with_pixels(sweep, [&](std::vector<std::uint8_t>& pixels, const UltrasoundImage& frame) {
        const int width = frame.pixels.width();
        for (std::size_t i = 0; i < pixels.size(); ++i) {
          const auto at = static_cast<int>(i);
          const Eigen::Vector2d p = frame.grid.at(at % width, at / width).mm.head<2>();
          pixels[i] = grey_at(frame, source_of(p, frame.outline, factor));
        }
      }).frames();
  for (TrackedImage& tracked : frames) {
    auto& outline = tracked.frame.outline;
    if (!outline) continue;
    const double depth_mm = outline->radius_max_mm - outline->radius_min_mm;
    outline->radius_max_mm = outline->radius_min_mm + std::min(factor, 1.0) * depth_mm;
  }
  return sweep_of(std::move(frames), sweep);
}

Sweep delayed(const Sweep& sweep, Duration delay) {
  std::vector<TrackedImage> frames;
  for (const TrackedImage& tracked : sweep.frames()) {
    const auto pose = pose_at(sweep, tracked.frame.acquired - delay);
    if (!pose) continue;
    frames.push_back(tracked);
    frames.back().reference_from_image = *pose;
  }
  NAV_CHECK(!frames.empty(), delay.count());
  return sweep_of(std::move(frames), sweep);
}

Sweep miscalibrated(const Sweep& sweep, double shift_mm, double turn_rad, std::uint64_t seed) {
  sim::Random random(seed, 0x70726f6265);
  const Eigen::Vector3d axis = random.direction();
  return held_elsewhere(sweep, {Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, axis)),
                                shift_mm * random.direction()});
}

Sweep shifted(const Sweep& sweep, const Eigen::Vector3d& shift_mm) {
  return held_elsewhere(sweep, {Eigen::Quaterniond::Identity(), shift_mm});
}

}  // namespace nav::bench
