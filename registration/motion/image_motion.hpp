// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "nav/sweep.hpp"

namespace nav::registration {

/// Position and motion of an ultrasound image at the time of its acquisition, Reference.
struct ImageMotion {
  double time_s;                  ///< Since the first image of the sweep.
  Eigen::Vector3d middle_mm;      ///< Middle of the image.
  Eigen::Matrix3d axes;           ///< Columns: the image's x, y and normal.
  Eigen::Vector3d turn_rad_s;     ///< Rotation vector per second.
  Eigen::Vector3d velocity_mm_s;  ///< Velocity of the middle.
};

/// Returns the motion of each image in `images`. It is estimated from the recorded images up to
/// 0.15 s before and after; 0 if there are none. Precondition: every image has the time of one of
/// the recorded images.
std::vector<ImageMotion> image_motions(const Sweep& images, const Sweep& recorded);

}  // namespace nav::registration
