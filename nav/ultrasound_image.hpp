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

/// Positions of the pixel centres in the Image frame, mm: p = origin_mm + mm_per_pixel · (column,
/// row). The map of a calibrated probe is not exactly orthogonal (real PLUS calibrations shear by
/// degrees), so mm_per_pixel is a full 2 × 2 matrix. The Image frame is oriented so that its first
/// column is (sx, 0).
struct PixelGrid {
  Eigen::Matrix2d mm_per_pixel;
  Eigen::Vector2d origin_mm;

  /// Grid of orthogonal pixels. The origin of the Image frame is the centre of the first row, which
  /// is the transducer face.
  static PixelGrid centred(int width, double spacing_x_mm, double spacing_y_mm);
  [[nodiscard]] Point<frames::Image> at(double column, double row) const;
  /// Pixel coordinates (column, row) of a point in the plane; z is ignored.
  [[nodiscard]] Eigen::Vector2d pixel_of(const Point<frames::Image>& p) const;
  /// Deviation of rows and columns from orthogonal, rad.
  [[nodiscard]] double shear_rad() const;
};

/// Rejects a grid that is not finite, has a spacing outside [1e-4, 100] mm per pixel, or has rows
/// and columns more than 20° from orthogonal.
Result<void> validate(const PixelGrid& grid);

/// The part of an image that a convex (curvilinear or sector) probe insonified: the ring segment
/// between two radii about an apex. Absent for a linear probe, which insonifies the whole
/// rectangle.
struct SectorOutline {
  Eigen::Vector2d apex_mm;  ///< Image frame, mm; y < 0: behind the transducer face.
  double radius_min_mm;
  double radius_max_mm;
  double half_angle_rad;  ///< Half of the opening angle about +y, in (0, pi/2).
  [[nodiscard]] bool contains(const Eigen::Vector2d& p_image_mm) const;
};

/// One B-mode ultrasound image. Columns increase towards the marked side, rows increase with depth
/// (PLUS "MF").
struct UltrasoundImage {
  Timestamp acquired{};  ///< Time of the echoes, session clock.
  Timestamp received{};  ///< Time at which the bytes arrived, session clock.
  std::uint64_t sequence = 0;
  Image2d<std::uint8_t> pixels;  ///< Brightness; all that measures reads these.
  PixelGrid grid;
  std::optional<SectorOutline> outline{};
  bool clock_unsure = false;  ///< The clock of its device is not known well yet.
  /// Colours, which flat ultrasound views draw: of the size of pixels, which are their luma. Empty:
  /// a grey image.
  Image2d<Rgb8> colours{};
};

/// Sets the pixels of a frame to the luma of an image, and its colours to the image unless all of
/// it is grey.
void set_colours(UltrasoundImage& frame, Image2d<Rgb8> image);

/// Lower and upper corner of the box around the image's pixel centres, Image frame, mm.
std::pair<Eigen::Vector2d, Eigen::Vector2d> box_mm(const UltrasoundImage& frame);
/// Length of that box's diagonal, mm.
double extent_mm(const UltrasoundImage& frame);

}  // namespace nav
