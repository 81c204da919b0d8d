// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

/// Errors of tracker, calibration and scanner that a sweep shows together with the pose: a pose
/// that is found without them absorbs a part of each.
namespace nav::registration {

/// Number of parameters of ImageErrors: delay, scale of depth and width, rotation, shift.
inline constexpr int kErrorParameters = 9;
using ErrorVector = Eigen::Matrix<double, kErrorParameters, 1>;

/// Errors that all images of a sweep share.
struct ImageErrors {
  double delay_s = 0;  ///< Images are later than their poses; negative: earlier.
  /// True over assumed size of a pixel, along the beam and across the images.
  double depth_scale = 1, width_scale = 1;
  /// Rotation vector, rad, and shift, mm, in the image's axes about its middle, which correct the
  /// calibration.
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero(), shift_mm = Eigen::Vector3d::Zero();

  /// [delay s | depth scale - 1, width scale - 1 | rotation rad | shift mm].
  [[nodiscard]] ErrorVector vector() const;
  static ImageErrors of(const ErrorVector& values);
  [[nodiscard]] bool none() const { return vector().isZero(0); }
};

/// Standard deviations of the errors before a registration, from what is known of the system; 0: an
/// error is ruled out and not estimated.
struct ErrorSigmas {
  double delay_s = 0.2;
  double depth_scale = 0.02, width_scale = 0.02;
  double turn_rad = 0, shift_mm = 0;  ///< About and along each axis of the images.
  [[nodiscard]] ErrorVector vector() const;
};

}  // namespace nav::registration
