// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "devices/can/encoder_arm.hpp"

namespace nav::devices {

/// A joint that turns about \p axis of the frame before it, at \p place_mm in that frame.
inline ArmJoint arm_joint(int node, const Eigen::Vector3d& axis, const Eigen::Vector3d& place_mm) {
  ArmJoint joint{.node = node, .counts_per_turn = 1U << 16};
  joint.previous_from_joint.topLeftCorner<3, 3>() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
  joint.previous_from_joint.topRightCorner<3, 1>() = place_mm;
  return joint;
}

/// Six joints of an arm with links of 300 and 250 mm, with other zeros and directions each.
inline ArmModel six_joint_arm() {
  ArmModel arm;
  arm.joints = {arm_joint(1, {0, 0, 1}, {0, 0, 100}), arm_joint(2, {0, 1, 0}, {0, 0, 50}),
                arm_joint(3, {0, 0, 1}, {300, 0, 0}), arm_joint(4, {1, 0, 0}, {250, 0, 0}),
                arm_joint(5, {0, 1, 0}, {0, 0, 0}),   arm_joint(7, {1, 0, 0}, {0, 0, 0})};
  for (std::size_t i = 0; i < arm.joints.size(); ++i) {
    arm.joints[i].zero_counts = static_cast<std::uint32_t>(1000 * i);
    arm.joints[i].reversed = i % 2 == 1;
  }
  arm.last_from_body.topRightCorner<3, 1>() = Eigen::Vector3d(80, 0, 0);
  return arm;
}

}  // namespace nav::devices
