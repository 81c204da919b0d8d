// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/emulated_arm.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace nav::devices {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kUpperMm = 450, kLowerMm = 400, kHandMm = 90;
constexpr std::uint32_t kEmulatedSteps = 1U << 18;
/// Angles and lengths have one unit by this length.
constexpr double kLeverMm = 300;

struct JointPlace {
  Eigen::Vector3d axis;
  Eigen::Vector3d place_mm;
};
/// Axis and position of each joint in the frame of the joint before it.
const std::array<JointPlace, 6> kJoints{{{{0, 0, 1}, {0, 0, 0}},
                                         {{0, 1, 0}, {0, 0, 120}},
                                         {{0, 0, 1}, {kUpperMm, 0, 0}},
                                         {{1, 0, 0}, {kLowerMm, 0, 0}},
                                         {{0, 1, 0}, {0, 0, 0}},
                                         {{1, 0, 0}, {0, 0, 0}}}};

/// Twist from one pose to another, in units of rad: shift above, rotation below.
Vector6 difference(const Eigen::Matrix4d& from, const Eigen::Matrix4d& to) {
  const Eigen::AngleAxisd turn(
      Eigen::Matrix3d(to.topLeftCorner<3, 3>() * from.topLeftCorner<3, 3>().transpose()));
  Vector6 twist;
  twist << (to - from).topRightCorner<3, 1>() / kLeverMm, turn.angle() * turn.axis();
  return twist;
}

/// Derivative of the pose by each angle.
Eigen::Matrix<double, 6, Eigen::Dynamic> slopes(const ArmModel& arm,
                                                const std::vector<double>& angles) {
  Eigen::Matrix<double, 6, Eigen::Dynamic> out(6, static_cast<Eigen::Index>(angles.size()));
  const Eigen::Vector3d body = arm_pose(arm, angles).base_from_body.topRightCorner<3, 1>();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < angles.size(); ++i) {
    pose = pose * Eigen::Isometry3d(arm.joints[i].previous_from_joint);
    const Eigen::Vector3d axis = pose.linear().col(2);
    out.col(static_cast<Eigen::Index>(i)) << axis.cross(body - pose.translation()) / kLeverMm, axis;
    pose = pose * Eigen::AngleAxisd(angles[i], Eigen::Vector3d::UnitZ());
  }
  return out;
}

}  // namespace

std::vector<double> emulated_arm_start_rad() { return {0, 0.4, 1.3, 0.5, 0.7, -0.3}; }

ArmModel emulated_arm(const Eigen::Matrix4d& base_from_body) {
  ArmModel arm;
  for (std::size_t i = 0; i < kJoints.size(); ++i) {
    ArmJoint joint{.node = static_cast<int>(i) + 1, .counts_per_turn = kEmulatedSteps};
    // Encoders are mounted as they come: with a zero and a direction of their own.
    joint.zero_counts = static_cast<std::uint32_t>(20000 * (i + 1));
    joint.reversed = i % 2 == 1;
    joint.previous_from_joint.topLeftCorner<3, 3>() =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), kJoints[i].axis)
            .toRotationMatrix();
    joint.previous_from_joint.topRightCorner<3, 1>() = kJoints[i].place_mm;
    arm.joints.push_back(joint);
  }
  arm.last_from_body(0, 3) = kHandMm;
  const Eigen::Isometry3d reached(arm_pose(arm, emulated_arm_start_rad()).base_from_body);
  Eigen::Isometry3d wanted(base_from_body);
  // Exactly a rotation: the file of the arm is checked for it.
  wanted.linear() = Eigen::Quaterniond(wanted.linear()).normalized().toRotationMatrix();
  arm.joints[0].previous_from_joint =
      (wanted * reached.inverse() * Eigen::Isometry3d(arm.joints[0].previous_from_joint)).matrix();
  return arm;
}

std::optional<std::vector<double>> angles_at_pose(const ArmModel& arm,
                                                  const Eigen::Matrix4d& base_from_body,
                                                  std::vector<double> start_rad) {
  constexpr int kMostSteps = 60;
  constexpr double kDamping = 1e-3;
  constexpr double kMostStepRad = 0.3;
  constexpr double kReachedMm = 1e-3, kReachedRad = 1e-6;
  for (int step = 0; step < kMostSteps; ++step) {
    const Vector6 off = difference(arm_pose(arm, start_rad).base_from_body, base_from_body);
    if (!off.allFinite()) return std::nullopt;
    if (kLeverMm * off.head<3>().norm() < kReachedMm && off.tail<3>().norm() < kReachedRad) {
      return start_rad;
    }
    const auto slope = slopes(arm, start_rad);
    const Eigen::Matrix<double, 6, 6> damped =
        slope * slope.transpose() +
        kDamping * off.squaredNorm() * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::VectorXd by = slope.transpose() * damped.ldlt().solve(off);
    const double most = by.cwiseAbs().maxCoeff();
    if (!std::isfinite(most)) return std::nullopt;
    if (most > kMostStepRad) by *= kMostStepRad / most;
    for (std::size_t i = 0; i < start_rad.size(); ++i) {
      start_rad[i] += by[static_cast<Eigen::Index>(i)];
    }
  }
  return std::nullopt;
}

}  // namespace nav::devices
