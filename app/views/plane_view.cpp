// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/plane_view.hpp"

#include <algorithm>
#include <cmath>

namespace nav::app {

PlaneView fit(const UltrasoundFrame& frame, int x, int y, int width, int height) {
  const auto [low, high] = box_mm(frame);
  constexpr double kMargin = 1.04;
  const Eigen::Vector2d size = (high - low).cwiseMax(1e-3);
  const double scale = kMargin * std::max(size.x() / width, size.y() / height);
  const Eigen::Vector2d centre = 0.5 * (low + high);
  return {.x = x,
          .y = y,
          .width = width,
          .height = height,
          .origin_mm = centre - 0.5 * scale * Eigen::Vector2d(width, height),
          .mm_per_px = scale};
}

namespace {

/// intensity() with the inverse of the grid's matrix, which is the same for every point.
double intensity_by(const UltrasoundFrame& frame, const Eigen::Matrix2d& pixel_from_mm,
                    const Eigen::Vector2d& p_mm) {
  const Eigen::Vector2d pixel = pixel_from_mm * (p_mm - frame.grid.origin_mm);
  const int w = frame.pixels.width();
  const int h = frame.pixels.height();
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= w - 1 && pixel.y() <= h - 1)) return -1;
  if (frame.outline && !frame.outline->contains(p_mm)) return -1;
  const int c = std::min(static_cast<int>(pixel.x()), std::max(w - 2, 0));
  const int r = std::min(static_cast<int>(pixel.y()), std::max(h - 2, 0));
  const double u = pixel.x() - c;
  const double v = pixel.y() - r;
  const int c1 = std::min(c + 1, w - 1);
  const int r1 = std::min(r + 1, h - 1);
  return (1 - v) * ((1 - u) * frame.pixels.at(c, r) + u * frame.pixels.at(c1, r)) +
         v * ((1 - u) * frame.pixels.at(c, r1) + u * frame.pixels.at(c1, r1));
}

}  // namespace

double intensity(const UltrasoundFrame& frame, const Eigen::Vector2d& p_mm) {
  return intensity_by(frame, frame.grid.mm_per_pixel.inverse(), p_mm);
}

void draw_ultrasound(render::Canvas& canvas, const PlaneView& view, const UltrasoundFrame& frame) {
  const Eigen::Matrix2d pixel_from_mm = frame.grid.mm_per_pixel.inverse();
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const double value = intensity_by(frame, pixel_from_mm, view.point_of(x, y));
      if (value < 0) continue;
      const auto grey = static_cast<std::uint8_t>(std::lround(value));
      canvas.set(view.x + x, view.y + y, {grey, grey, grey, 255});
    }
  }
}

}  // namespace nav::app
