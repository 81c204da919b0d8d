// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/bone/scan_lines.hpp"

#include <algorithm>
#include <cmath>

#include "nav/check.hpp"
#include "nav/index.hpp"
#include "registration/similarity/image_outline.hpp"

namespace nav::registration {
namespace {

constexpr int kMostLines = 320;
constexpr double kLeastStepMm = 0.1;
constexpr double kMostStepMm = 0.5;

}  // namespace

ScanLines::ScanLines(const Sweep& sweep, double line_mm) {
  NAV_CHECK(line_mm > 0, line_mm);
  const UltrasoundImage& frame = sweep.frames().front().frame;
  const int width = frame.pixels.width();
  const int height = frame.pixels.height();
  step_mm_ = std::clamp(frame.grid.mm_per_pixel.col(1).norm(), kLeastStepMm, kMostStepMm);
  double length_mm = 0;
  const auto add_lines = [&](double wide_mm, const auto& line_at) {
    line_mm_ = std::max({line_mm, frame.grid.mm_per_pixel.col(0).norm(), wide_mm / kMostLines});
    lines_ = std::max(1, static_cast<int>(std::floor(wide_mm / line_mm_)) + 1);
    for (int line = 0; line < lines_; ++line) line_at((line - 0.5 * (lines_ - 1)) * line_mm_);
  };
  if (frame.outline) {
    const SectorOutline& o = *frame.outline;
    const double middle_mm = 0.5 * (o.radius_min_mm + o.radius_max_mm);
    length_mm = o.radius_max_mm - o.radius_min_mm;
    add_lines(2 * o.half_angle_rad * middle_mm, [&](double arc_mm) {
      const double angle = arc_mm / middle_mm;
      along_.emplace_back(std::sin(angle), std::cos(angle));
      start_mm_.emplace_back(o.apex_mm + o.radius_min_mm * along_.back());
    });
  } else {
    const auto [low, high] = box_mm(frame);
    length_mm = high.y() - low.y();
    add_lines(high.x() - low.x(), [&, low = low, high = high](double x) {
      along_.emplace_back(0, 1);
      start_mm_.emplace_back(0.5 * (low.x() + high.x()) + x, low.y());
    });
  }
  depths_ = std::max(1, static_cast<int>(std::floor(length_mm / step_mm_)) + 1);
  const std::vector<std::uint8_t> dark = never_lit(sweep);
  taps_.assign(samples(), {-1, 0, 0});
  first_.assign(as_size(lines_), depths_);
  for (int depth = 0; depth < depths_; ++depth) {
    for (int line = 0; line < lines_; ++line) {
      const Eigen::Vector2d p = at_mm(line, depth);
      const Eigen::Vector2d pixel = frame.grid.pixel_of({{p.x(), p.y(), 0}});
      if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= width - 1 &&
            pixel.y() <= height - 1)) {
        continue;
      }
      const int column = std::clamp(static_cast<int>(pixel.x()), 0, std::max(width - 2, 0));
      const int row = std::clamp(static_cast<int>(pixel.y()), 0, std::max(height - 2, 0));
      Tap& tap = taps_[as_size(depth) * as_size(lines_) + as_size(line)];
      tap.pixel = row * width + column;
      tap.right =
          static_cast<std::uint16_t>(width < 2 ? 0 : std::lround(256 * (pixel.x() - column)));
      tap.below = static_cast<std::uint16_t>(height < 2 ? 0 : std::lround(256 * (pixel.y() - row)));
      int& first = first_[as_size(line)];
      if (dark[as_size(tap.pixel)] == 0) first = std::min(first, depth);
    }
  }
}

std::size_t ScanLines::samples() const { return as_size(lines_) * as_size(depths_); }

Eigen::Vector2d ScanLines::at_mm(int line, double depth) const {
  return start_mm_[as_size(line)] + depth * step_mm_ * along_[as_size(line)];
}

std::vector<float> ScanLines::sample(const Image2d<std::uint8_t>& pixels) const {
  std::vector<float> out(taps_.size(), 0);
  const std::uint8_t* grey = pixels.pixels().data();
  const std::size_t down = pixels.height() < 2 ? 0 : as_size(pixels.width());
  const std::size_t next = pixels.width() < 2 ? 0 : 1;
  for (std::size_t i = 0; i < taps_.size(); ++i) {
    const Tap& tap = taps_[i];
    if (tap.pixel < 0) continue;
    const std::uint8_t* at = grey + tap.pixel;
    const int upper = at[0] * (256 - tap.right) + at[next] * tap.right;
    const int lower = at[down] * (256 - tap.right) + at[down + next] * tap.right;
    out[i] = static_cast<float>(upper * (256 - tap.below) + lower * tap.below) * 0x1p-16f;
  }
  return out;
}

}  // namespace nav::registration
