// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/trackers/encoder_arm.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "nav/check.hpp"
#include "sim/random.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using Mat = Eigen::Matrix3d;

constexpr std::uint64_t kArmNoiseStream = 0x61726d;
constexpr std::uint64_t kCalibrationStream = 0x63616c;

Mat turn(double angle, const Vec& axis) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}
Mat about_x(double angle) { return turn(angle, Vec::UnitX()); }
Mat about_y(double angle) { return turn(angle, Vec::UnitY()); }
Mat about_z(double angle) { return turn(angle, Vec::UnitZ()); }

Eigen::Matrix4d pose_of(const EncoderArmOptions& o, const JointAngles& q) {
  const Mat shoulder = about_z(q[0]) * about_y(q[1]);
  const Mat elbow = shoulder * about_y(q[2]);
  const Mat hand = elbow * about_x(q[3]) * about_y(q[4]) * about_x(q[5]);
  Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
  pose.topLeftCorner<3, 3>() = hand;
  pose.topRightCorner<3, 1>() = Vec(0, 0, o.column_mm) + shoulder * Vec(o.upper_mm, 0, 0) +
                                elbow * Vec(o.forearm_mm, 0, 0) + hand * Vec(o.tool_mm, 0, 0);
  return pose;
}

}  // namespace

Result<void> validate(const EncoderArmOptions& o) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("encoder arm: expected ") + what};
  };
  const auto length = [](double mm) { return mm > 0 && mm < 1e4; };
  if (!length(o.upper_mm) || !length(o.forearm_mm)) return reject("links of 0 to 10 000 mm");
  if (!(std::abs(o.column_mm) < 1e4)) return reject("a column within 10 000 mm");
  if (!(o.tool_mm >= 0 && o.tool_mm < 1e4)) return reject("a tool of 0 to 10 000 mm");
  if (o.counts_per_turn < 16) return reject("at least 16 counts per turn");
  if (!(o.noise_counts >= 0 && o.noise_counts < 1e3)) return reject("a noise in [0, 1000) counts");
  if (!(o.offset_rad >= 0 && o.offset_rad < 0.1)) return reject("an offset in [0, 0.1) rad");
  if (!(o.length_error_mm >= 0 && o.length_error_mm < 10)) {
    return reject("a length error in [0, 10) mm");
  }
  return {};
}

EncoderArm::EncoderArm(const EncoderArmOptions& options) : options_(options), believed_(options) {
  const auto ok = validate(options);
  NAV_CHECK(ok.has_value(), ok.has_value() ? "" : ok.error().message);
  const auto error = [&](std::uint64_t k) {
    return normal_at(options.seed, kCalibrationStream, k);
  };
  for (std::size_t i = 0; i < offsets_.size(); ++i) offsets_[i] = options.offset_rad * error(i);
  believed_.upper_mm += options.length_error_mm * error(6);
  believed_.forearm_mm += options.length_error_mm * error(7);
  believed_.tool_mm += options.length_error_mm * error(8);
}

double EncoderArm::resolution_rad() const {
  return 2 * std::numbers::pi / options_.counts_per_turn;
}

Eigen::Matrix4d EncoderArm::forward(const JointAngles& joints) const {
  return pose_of(options_, joints);
}

std::optional<JointAngles> EncoderArm::inverse(const Eigen::Matrix4d& pose) const {
  const EncoderArmOptions& o = options_;
  const Mat hand = pose.topLeftCorner<3, 3>();
  const Vec wrist = pose.topRightCorner<3, 1>() - hand * Vec(o.tool_mm, 0, 0);
  const double out = wrist.head<2>().norm();
  const double up = wrist.z() - o.column_mm;
  const double bend =
      (out * out + up * up - o.upper_mm * o.upper_mm - o.forearm_mm * o.forearm_mm) /
      (2 * o.upper_mm * o.forearm_mm);
  if (!(std::abs(bend) <= 1)) return std::nullopt;
  JointAngles q{};
  q[0] = std::atan2(wrist.y(), wrist.x());
  q[2] = std::acos(bend);
  q[1] = std::atan2(-up, out) -
         std::atan2(o.forearm_mm * std::sin(q[2]), o.upper_mm + o.forearm_mm * bend);
  const Mat rest = (about_z(q[0]) * about_y(q[1] + q[2])).transpose() * hand;
  const double sine = std::hypot(rest(1, 0), rest(2, 0));
  q[4] = std::atan2(sine, rest(0, 0));
  // With a straight wrist only the sum (or difference) of the two outer angles is determined.
  constexpr double kStraight = 1e-9;
  if (sine > kStraight) {
    q[3] = std::atan2(rest(1, 0), -rest(2, 0));
    q[5] = std::atan2(rest(0, 1), rest(0, 2));
  } else {
    q[5] = std::atan2(rest(2, 1), rest(1, 1));
    q[4] = rest(0, 0) > 0 ? 0 : std::numbers::pi;
    if (rest(0, 0) < 0) q[5] = std::atan2(-rest(1, 2), rest(1, 1));
  }
  return q;
}

Observation EncoderArm::observe(const Eigen::Matrix4d& truth, std::uint64_t body,
                                std::uint64_t sample) const {
  auto joints = inverse(truth);
  if (!joints) return {TrackingStatus::kOutOfVolume};
  const double step = resolution_rad();
  for (std::size_t i = 0; i < joints->size(); ++i) {
    const double noise =
        options_.noise_counts * normal_at(options_.seed, kArmNoiseStream + body, 6 * sample + i);
    (*joints)[i] = step * std::round((*joints)[i] / step + noise) + offsets_[i];
  }
  return {TrackingStatus::kOk, pose_of(believed_, *joints)};
}

}  // namespace nav::sim
