// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "nav/sweep.hpp"

namespace nav::registration {

/// Where a picture lay and how it moved when it was taken, Reference.
struct PictureMotion {
  double time_s;                  ///< Since the first picture of the sweep.
  Eigen::Vector3d middle_mm;      ///< Of the picture.
  Eigen::Matrix3d axes;           ///< Columns: the picture's x, y and normal.
  Eigen::Vector3d turn_rad_s;     ///< Rotation vector per second.
  Eigen::Vector3d velocity_mm_s;  ///< Of its middle.
};

/// Of each of some pictures. How they moved is told by the recorded pictures about, up to 0.15 s
/// before and after; 0 where there are none. Precondition: every picture's time is that of one of
/// the recorded.
std::vector<PictureMotion> picture_motions(const Sweep& pictures, const Sweep& recorded);

}  // namespace nav::registration
