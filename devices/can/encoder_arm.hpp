// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::devices {

/// One joint of a passive arm, with its encoder.
struct ArmJoint {
  int node = 1;  ///< Number of the encoder on the bus, 1 to 127.
  /// Calibrated pose of the joint's frame in that of the joint before it (the first: in the base,
  /// which is the tracker frame) at angle 0, mm. The joint turns about the z axis of its frame.
  Eigen::Matrix4d previous_from_joint = Eigen::Matrix4d::Identity();
  std::uint32_t counts_per_turn = 65536;  ///< 16 to 2^31.
  std::uint32_t zero_counts = 0;          ///< Reading at angle 0, < counts_per_turn.
  bool reversed = false;                  ///< The angle falls while the reading rises.
  double zero_sigma_rad = 0;              ///< Standard deviation of the calibrated zero, [0, 0.1].
  double link_sigma_mm = 0;               ///< That of the joint's place, along each axis, [0, 10].
};

/// Position in which the user shows the arm before it is believed: joints that are mixed up,
/// turned round or have another zero show there.
struct ArmRest {
  std::vector<double> angles_rad{};  ///< One for each joint.
  double tolerance_rad = 0;          ///< > 0.
};

/// Calibrated kinematics of an arm.
struct ArmModel {
  std::vector<ArmJoint> joints{};  ///< From the base to the body; 1 to 16.
  Eigen::Matrix4d last_from_body = Eigen::Matrix4d::Identity();  ///< mm.
  std::optional<ArmRest> rest{};
};
/// Rejects values out of range, matrices that are not rigid, and nodes that repeat, by name:
/// "joints[2].node: expected …, found …".
Result<void> validate(const ArmModel& arm);

/// Angle of a joint in (−π, π], rad. Readings beyond one turn count modulo a turn.
double joint_angle_rad(const ArmJoint& joint, std::uint32_t counts);
/// Reading nearest to an angle.
std::uint32_t joint_counts(const ArmJoint& joint, double angle_rad);

struct ArmPose {
  Eigen::Matrix4d base_from_body = Eigen::Matrix4d::Identity();  ///< mm.
  /// Standard deviation of the body's origin (root of the trace of its covariance), mm, from the
  /// resolution of the encoders and the calibration's own figures, to first order.
  double error_mm = 0;
};
/// Forward kinematics. \p angles_rad: one for each joint. Precondition: validate(arm).
ArmPose arm_pose(const ArmModel& arm, std::span<const double> angles_rad);

/// The joint that is farthest from the rest position, if one is beyond the tolerance: a sentence
/// with its number, node, angle and what was expected.
std::optional<std::string> off_rest(const ArmModel& arm, std::span<const double> angles_rad);

}  // namespace nav::devices
