// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/encoder_arm.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <set>
#include <sstream>

#include "devices/can/canopen.hpp"
#include "nav/check.hpp"

namespace nav::devices {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr std::size_t kMostJoints = 16;

template <class T>
Error wrong_arm(const std::string& where, const char* expected, const T& found) {
  std::ostringstream text;
  text << where << ": expected " << expected << ", found " << found;
  return {ErrorCode::kUsage, text.str()};
}

bool is_rigid(const Eigen::Matrix4d& m) {
  constexpr double kTolerance = 1e-4;
  const Eigen::Matrix3d r = m.topLeftCorner<3, 3>();
  return m.allFinite() && (r * r.transpose() - Eigen::Matrix3d::Identity()).norm() < kTolerance &&
         r.determinant() > 0 && (m.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() < kTolerance;
}

Result<void> validate_joint(const ArmJoint& joint, const std::string& where) {
  if (joint.node < 1 || joint.node > kMostCanNodes) {
    return wrong_arm(where + ".node", "1 to 127", joint.node);
  }
  if (!is_rigid(joint.previous_from_joint)) {
    return wrong_arm(where + ".previous_from_joint", "a rotation and a translation in mm",
                     "another matrix");
  }
  if (joint.counts_per_turn < 16 || joint.counts_per_turn > (1U << 31)) {
    return wrong_arm(where + ".counts_per_turn", "16 to 2147483648", joint.counts_per_turn);
  }
  if (joint.zero_counts >= joint.counts_per_turn) {
    return wrong_arm(where + ".zero_counts", "less than the counts per turn", joint.zero_counts);
  }
  if (!(joint.zero_sigma_rad >= 0 && joint.zero_sigma_rad <= 0.1)) {
    return wrong_arm(where + ".zero_sigma_rad", "0 to 0.1", joint.zero_sigma_rad);
  }
  if (!(joint.link_sigma_mm >= 0 && joint.link_sigma_mm <= 10)) {
    return wrong_arm(where + ".link_sigma_mm", "0 to 10", joint.link_sigma_mm);
  }
  return {};
}

}  // namespace

Result<void> validate(const ArmModel& arm) {
  if (arm.joints.empty() || arm.joints.size() > kMostJoints) {
    return wrong_arm("joints", "1 to 16 joints", arm.joints.size());
  }
  std::set<int> nodes;
  for (std::size_t i = 0; i < arm.joints.size(); ++i) {
    const std::string where = "joints[" + std::to_string(i) + "]";
    if (auto ok = validate_joint(arm.joints[i], where); !ok) return ok;
    if (!nodes.insert(arm.joints[i].node).second) {
      return wrong_arm(where + ".node", "a node of its own for each joint", arm.joints[i].node);
    }
  }
  if (!is_rigid(arm.last_from_body)) {
    return wrong_arm("last_from_body", "a rotation and a translation in mm", "another matrix");
  }
  if (!arm.rest) return {};
  if (arm.rest->angles_rad.size() != arm.joints.size()) {
    return wrong_arm("rest.angles", "one angle for each joint", arm.rest->angles_rad.size());
  }
  for (const double angle : arm.rest->angles_rad) {
    if (!std::isfinite(angle)) return wrong_arm("rest.angles", "numbers", angle);
  }
  if (!(arm.rest->tolerance_rad > 0 && arm.rest->tolerance_rad < std::numbers::pi)) {
    return wrong_arm("rest.tolerance", "more than 0 and less than half a turn",
                     arm.rest->tolerance_rad);
  }
  return {};
}

double joint_angle_rad(const ArmJoint& joint, std::uint32_t counts) {
  const auto turn = static_cast<std::int64_t>(joint.counts_per_turn);
  std::int64_t steps = (static_cast<std::int64_t>(counts) - joint.zero_counts) % turn;
  if (steps < 0) steps += turn;
  if (joint.reversed && steps != 0) steps = turn - steps;
  if (2 * steps > turn) steps -= turn;
  return kTurn * static_cast<double>(steps) / static_cast<double>(turn);
}

std::uint32_t joint_counts(const ArmJoint& joint, double angle_rad) {
  const auto turn = static_cast<std::int64_t>(joint.counts_per_turn);
  std::int64_t steps = std::llround(angle_rad / kTurn * static_cast<double>(turn)) % turn;
  if (joint.reversed) steps = -steps;
  return static_cast<std::uint32_t>(((steps + joint.zero_counts) % turn + turn) % turn);
}

ArmPose arm_pose(const ArmModel& arm, std::span<const double> angles_rad) {
  NAV_CHECK(angles_rad.size() == arm.joints.size(), "one angle for each joint");
  struct Axis {
    Eigen::Vector3d direction, origin;
  };
  std::vector<Axis> axes;
  Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
  for (std::size_t i = 0; i < arm.joints.size(); ++i) {
    pose = pose * arm.joints[i].previous_from_joint;
    axes.push_back({pose.block<3, 1>(0, 2), pose.block<3, 1>(0, 3)});
    Eigen::Matrix4d turned = Eigen::Matrix4d::Identity();
    turned.topLeftCorner<3, 3>() =
        Eigen::AngleAxisd(angles_rad[i], Eigen::Vector3d::UnitZ()).toRotationMatrix();
    pose = pose * turned;
  }
  pose = pose * arm.last_from_body;
  const Eigen::Vector3d body = pose.topRightCorner<3, 1>();
  double variance_mm2 = 0;
  for (std::size_t i = 0; i < arm.joints.size(); ++i) {
    const ArmJoint& joint = arm.joints[i];
    const double step = kTurn / joint.counts_per_turn;
    const double angle_variance = step * step / 12 + joint.zero_sigma_rad * joint.zero_sigma_rad;
    const double lever_mm = axes[i].direction.cross(body - axes[i].origin).norm();
    variance_mm2 +=
        lever_mm * lever_mm * angle_variance + 3 * joint.link_sigma_mm * joint.link_sigma_mm;
  }
  return {pose, std::sqrt(variance_mm2)};
}

std::optional<std::string> off_rest(const ArmModel& arm, std::span<const double> angles_rad) {
  if (!arm.rest) return std::nullopt;
  std::size_t farthest = 0;
  double most = 0;
  for (std::size_t i = 0; i < angles_rad.size(); ++i) {
    const double off = std::abs(std::remainder(angles_rad[i] - arm.rest->angles_rad[i], kTurn));
    if (off <= most) continue;
    most = off;
    farthest = i;
  }
  if (most <= arm.rest->tolerance_rad) return std::nullopt;
  const auto degrees = [](double rad) { return std::round(rad * 1800 / std::numbers::pi) / 10; };
  std::ostringstream text;
  text << "joint " << farthest + 1 << " (node " << arm.joints[farthest].node << ") is at "
       << degrees(angles_rad[farthest]) << " degrees, expected "
       << degrees(arm.rest->angles_rad[farthest]) << " within " << degrees(arm.rest->tolerance_rad)
       << ": move the arm to its rest position; if it is there, the joint's zero, direction or "
          "node is wrong";
  return text.str();
}

}  // namespace nav::devices
