// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "nav/ultrasound_image.hpp"
#include "render/canvas.hpp"

namespace nav::app {

/// Rectangle of a canvas that shows part of the Image plane at one scale.
struct PlaneView {
  int x, y, width, height;    ///< Canvas pixels.
  Eigen::Vector2d origin_mm;  ///< Position of the top left pixel, Image frame.
  double mm_per_px;

  [[nodiscard]] Eigen::Vector2d pixel_of(const Eigen::Vector2d& p_mm) const {
    return Eigen::Vector2d(x, y) + (p_mm - origin_mm) / mm_per_px;
  }
  [[nodiscard]] Eigen::Vector2d point_of(int column, int row) const {
    return origin_mm + mm_per_px * Eigen::Vector2d(column, row);
  }
  [[nodiscard]] bool contains(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= x && pixel.x() < x + width && pixel.y() >= y && pixel.y() < y + height;
  }
};

/// Fits a whole ultrasound image, with its true proportions, into a rectangle of a canvas.
PlaneView fit(const UltrasoundImage& frame, int x, int y, int width, int height);

/// Grey value at a point of the Image frame, bilinear, 0 to 255; -1 outside the image's outline.
double intensity(const UltrasoundImage& frame, const Eigen::Vector2d& p_mm);

/// Draws the insonified part of the image, in its colours if it has some.
void draw_ultrasound(render::Canvas& canvas, const PlaneView& view, const UltrasoundImage& frame);

}  // namespace nav::app
