// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "nav/transform.hpp"
#include "sim/random.hpp"

namespace nav::sim {

/// Random orientation in which a body is mounted: a rotation by 0.8 to 2.6 rad about any axis, so
/// that no test passes when coordinate frames are confused.
inline Eigen::Quaterniond random_mount(Random& random) {
  const double angle = random.uniform(0.8, 2.6);
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, random.direction()));
}

/// Pose of the image in the frame of the body that is clamped to the probe.
inline Transform<frames::Probe, frames::Image> mount_probe(Random random) {
  const Eigen::Vector3d at = Eigen::Vector3d(8.5, -31.2, 84.6) + random.offset(4);
  return {random_mount(random), at};
}

}  // namespace nav::sim
