// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "registration/similarity/similarity_cost.hpp"

namespace nav::registration {

/// The first \p columns of 1, cos, sin, cos 2, sin 2, … of a phase of the breath.
Eigen::VectorXd phase_basis(double phase, Eigen::Index columns);

/// Twist [rad | mm] of a series [60 rad | mm] at these values of its basis.
Vector6d phase_twist(const Eigen::MatrixXd& series, const Eigen::VectorXd& basis);

/// A rigid motion that repeats with every breath: one pose for each phase. The twist about a centre
/// is a Fourier series of the phase, so that neighbouring phases have neighbouring poses.
class PhaseMotion {
 public:
  /// One pose for all phases.
  explicit PhaseMotion(const Pose& mean, const Eigen::Vector3d& centre_ct_mm = {0, 0, 0});
  /// series: columns constant, cos 1, sin 1, cos 2, sin 2, …; [60 rad | mm], see kRotationScaleMm.
  PhaseMotion(const Pose& mean, const Eigen::Vector3d& centre_ct_mm, Eigen::MatrixXd series);

  /// phase: phase of the breath; any number, only its fractional part counts.
  [[nodiscard]] Pose ct_from_reference(double phase) const;
  /// This motion followed by a step of the tissue.
  [[nodiscard]] PhaseMotion after(const Transform<frames::Ct, frames::Ct>& step) const;
  /// Longest distance of a point of the CT between two phases, mm.
  [[nodiscard]] double amplitude_mm(const Point<frames::Ct>& at_mean) const;
  [[nodiscard]] const Eigen::MatrixXd& series() const { return series_; }

 private:
  Pose mean_;
  Eigen::Vector3d centre_;
  Eigen::MatrixXd series_;
};

}  // namespace nav::registration
