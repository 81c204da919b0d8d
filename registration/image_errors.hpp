// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

/// Errors of tracker, calibration and scanner that a sweep shows together with the pose: a pose
/// that is found without them absorbs a part of each.
namespace nav::registration {

/// Number of parameters of ImageErrors: delay, scale of depth and width, pressure, rotation, shift.
inline constexpr int kErrorParameters = 10;
using ErrorVector = Eigen::Matrix<double, kErrorParameters, 1>;

/// Share of ImageErrors::pressed_mm at a depth from the face, mm: the pressure of a face on soft
/// tissue reaches about as deep as the face is wide.
inline double pressed_share(double depth_mm) {
  constexpr double kReachMm = 30;
  return std::exp(-std::max(depth_mm, 0.0) / kReachMm);
}

/// Errors that all images of a sweep share.
struct ImageErrors {
  double delay_s = 0;  ///< Images are later than their poses; negative: earlier.
  /// True over assumed size of a pixel, along the beam and across the images.
  double depth_scale = 1, width_scale = 1;
  /// Distance along the beam by which images show the tissue at the face deeper than it lies in the
  /// CT, mm; at a depth, pressed_share() of it. A probe presses the tissue away, and sound is
  /// slower in the fat under the skin than the scanner assumes.
  double pressed_mm = 0;
  /// Rotation vector, rad, and shift, mm, in the image's axes about its middle, which correct the
  /// calibration.
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero(), shift_mm = Eigen::Vector3d::Zero();

  /// [delay s | depth scale - 1, width scale - 1 | pressed mm | rotation rad | shift mm].
  [[nodiscard]] ErrorVector vector() const;
  static constexpr Eigen::Index kPressedIndex = 3;  ///< Index of pressed_mm in vector().
  static ImageErrors of(const ErrorVector& values);
  [[nodiscard]] bool none() const { return vector().isZero(0); }
};

/// Standard deviations of the errors before a registration, from what is known of the system; 0: an
/// error is ruled out and not estimated.
struct ErrorSigmas {
  double delay_s = 0.2;
  double depth_scale = 0.02, width_scale = 0.02;
  double pressed_mm = 0;
  double turn_rad = 0, shift_mm = 0;  ///< About and along each axis of the images.
  /// Standard deviation of a further shift along the beam: layers of other speed of sound shift all
  /// that lies below them. Without shift_mm it does nothing.
  double layers_mm = 0;
  [[nodiscard]] ErrorVector vector() const;
};

}  // namespace nav::registration
