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

/// Passive arm that holds the body: column, upper arm, forearm, and a wrist of three axes that meet
/// in one point. Defaults: 2^16 counts per turn and a calibration that together give a few tenths
/// of a millimetre over a reach of 1 m, as stated for bench-top digitising arms.
struct EncoderArmOptions {
  double column_mm = 200;         ///< Height of the shoulder above the base, along z.
  double upper_mm = 550;          ///< > 0.
  double forearm_mm = 500;        ///< > 0.
  double tool_mm = 80;            ///< From the wrist to the body's origin, along its x, >= 0.
  int counts_per_turn = 65536;    ///< Resolution of each encoder, >= 16.
  double noise_counts = 0.3;      ///< Standard deviation before rounding, >= 0.
  double offset_rad = 5e-5;       ///< Standard deviation of a joint's calibration error, >= 0.
  double length_error_mm = 0.03;  ///< Standard deviation of the error of a link's length, >= 0.
  std::uint64_t seed = 1;
};

/// Rejects invalid options; the message names the first one out of range.
Result<void> validate(const EncoderArmOptions& options);

/// The body's pose is a product of rotations and links, Rz(q1) Ry(q2) Ry(q3) Rx(q4) Ry(q5) Rx(q6).
/// The encoders round its angles. Calibration errors of angles and lengths are constant.
class EncoderArm final : public TrackerSensor {
 public:
  /// Precondition: validate(options), otherwise a Bug.
  explicit EncoderArm(const EncoderArmOptions& options);
  [[nodiscard]] Observation observe(const Eigen::Matrix4d& truth, std::uint64_t body,
                                    std::uint64_t sample) const override;
  [[nodiscard]] const char* name() const override { return "encoder arm"; }
  /// Pose of the ideal arm.
  [[nodiscard]] Eigen::Matrix4d forward(const JointAngles& joints) const;
  /// Angles that reach a pose (elbow bent to one side), or nothing beyond the reach. Closed form.
  [[nodiscard]] std::optional<JointAngles> inverse(const Eigen::Matrix4d& pose) const;
  /// Angular resolution of the encoders, rad.
  [[nodiscard]] double resolution_rad() const;

 private:
  EncoderArmOptions options_;
  EncoderArmOptions believed_;  ///< Calibrated lengths.
  JointAngles offsets_{};
};

}  // namespace nav::sim
