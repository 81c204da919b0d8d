// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "devices/can/encoder_arm.hpp"

namespace nav::devices {

/// An arm of six joints without hardware: shoulder and elbow with links of 450 and 400 mm, and a
/// wrist whose three axes meet. Its base lies such that the body has this pose, mm, with bent
/// joints, from where it reaches some decimetres in all directions. Precondition: a rigid matrix.
ArmModel emulated_arm(const Eigen::Matrix4d& base_from_body);

/// Angles of the joints at which the body has a pose, rad, found from other angles by damped least
/// squares (Wampler 1986). Absent: it is not reached within 0.001 mm and 1e-6 rad. Precondition:
/// one start angle for each joint, a rigid matrix.
std::optional<std::vector<double>> angles_at_pose(const ArmModel& arm,
                                                  const Eigen::Matrix4d& base_from_body,
                                                  std::vector<double> start_rad);

/// Angles of emulated_arm() at the pose that it was made for, rad.
std::vector<double> emulated_arm_start_rad();

}  // namespace nav::devices
