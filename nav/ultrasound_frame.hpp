// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <utility>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "nav/time.hpp"
#include "nav/transform.hpp"

namespace nav {

/// Where pixel centres lie in the Image frame, mm: p = origin_mm + mm_per_pixel · (column, row).
/// A calibrated probe's map is not exactly orthogonal (real PLUS calibrations shear by degrees),
/// so it is a full 2 × 2 matrix; the Image frame is laid so that its first column is (sx, 0).
struct PixelGrid {
  Eigen::Matrix2d mm_per_pixel;
  Eigen::Vector2d origin_mm;

  /// Orthogonal pixels; origin mid first row, which is the transducer face.
  static PixelGrid centred(int width, double spacing_x_mm, double spacing_y_mm);
  [[nodiscard]] Point<frames::Image> at(double column, double row) const;
  /// Pixel coordinates (column, row) of a point in the plane; z is ignored.
  [[nodiscard]] Eigen::Vector2d pixel_of(const Point<frames::Image>& p) const;
  /// Angle by which rows and columns miss orthogonality, rad.
  [[nodiscard]] double shear_rad() const;
};

/// A refusal unless finite, invertible, each spacing within [1e-4, 100] mm per pixel.
Result<void> validate(const PixelGrid& grid);

/// The part of a picture that a convex (curvilinear or sector) probe really insonified: the ring
/// segment between two radii about an apex. Absent for a linear probe: the whole rectangle.
struct SectorOutline {
  Eigen::Vector2d apex_mm;  ///< Image frame, mm; y negative: behind the transducer face.
  double radius_min_mm;
  double radius_max_mm;
  double half_angle_rad;  ///< About +y, in (0, pi/2).
  [[nodiscard]] bool contains(const Eigen::Vector2d& p_image_mm) const;
};

/// One B-mode picture. Columns grow toward the marked side, rows grow deep (PLUS "MF").
struct UltrasoundFrame {
  Timestamp acquired;  ///< When the echoes happened, session clock.
  Timestamp received;  ///< When the bytes arrived, session clock.
  std::uint64_t sequence = 0;
  Image2d<std::uint8_t> pixels;
  PixelGrid grid;
  std::optional<SectorOutline> outline;
};

/// Lower and upper corner of the box around the image's pixel centres, Image frame, mm.
std::pair<Eigen::Vector2d, Eigen::Vector2d> box_mm(const UltrasoundFrame& frame);
/// Length of that box's diagonal, mm.
double extent_mm(const UltrasoundFrame& frame);

}  // namespace nav
