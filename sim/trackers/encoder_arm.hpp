// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "nav/result.hpp"
#include "sim/trackers/tracker_sensor.hpp"

namespace nav::sim {

/// Angles of the six joints, rad.
using JointAngles = std::array<double, 6>;

/// A passive arm that holds the body: column, upper arm, forearm, and a wrist of three axes that
/// meet in one point. Defaults: 2^16 counts per turn and a calibration that together give a few
/// tenths of a millimetre over a reach of 1 m, as bench-top digitising arms state.
struct EncoderArmOptions {
  double column_mm = 200;       ///< Height of the shoulder over the base, along z.
  double upper_mm = 550;        ///< > 0.
  double forearm_mm = 500;      ///< > 0.
  double tool_mm = 80;          ///< From the wrist to the body's origin, along the body's x, >= 0.
  int counts_per_turn = 65536;  ///< Of each encoder, >= 16.
  double noise_counts = 0.3;    ///< Standard deviation before rounding, >= 0.
  double offset_rad = 5e-5;     ///< Standard deviation of a joint's calibration error, >= 0.
  double length_error_mm = 0.03;  ///< The same of a link's length, >= 0.
  std::uint64_t seed = 1;
};

/// A refusal that names the first option out of range.
Result<void> validate(const EncoderArmOptions& options);

/// The body's pose is a product of rotations and links, Rz(q1) Ry(q2) Ry(q3) Rx(q4) Ry(q5) Rx(q6);
/// the encoders round its angles, and calibration errors of angles and lengths stay the same.
class EncoderArm final : public TrackerSensor {
 public:
  /// Precondition: validate(options), otherwise a Bug.
  explicit EncoderArm(const EncoderArmOptions& options);
  [[nodiscard]] Observation observe(const Eigen::Matrix4d& truth, std::uint64_t body,
                                    std::uint64_t sample) const override;
  [[nodiscard]] const char* name() const override { return "encoder arm"; }
  /// Pose of the perfect arm.
  [[nodiscard]] Eigen::Matrix4d forward(const JointAngles& joints) const;
  /// Angles that reach a pose (elbow bent to one side), or nothing beyond the reach. Closed form.
  [[nodiscard]] std::optional<JointAngles> inverse(const Eigen::Matrix4d& pose) const;
  /// Smallest angle that the encoders tell apart, rad.
  [[nodiscard]] double resolution_rad() const;

 private:
  EncoderArmOptions options_;
  EncoderArmOptions believed_;  ///< Lengths as calibrated.
  JointAngles offsets_{};
};

}  // namespace nav::sim
