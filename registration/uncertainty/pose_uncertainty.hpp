// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "nav/transform.hpp"

namespace nav::registration {

/// Covariance of an estimated ct_from_reference: the true map is exp(ω) about centre_ct followed by
/// the translation t, applied after the estimate: p = c + exp(ω)(p̂ − c) + t, all in Ct.
struct PoseUncertainty {
  Point<frames::Ct> centre_ct;             ///< c, mm.
  Eigen::Matrix<double, 6, 6> covariance;  ///< [rotation rad | translation mm], symmetric, >= 0.

  /// Covariance of a mapped point to first order, mm²: J Σ Jᵀ with J = [−[x − c]ₓ | I].
  [[nodiscard]] Eigen::Matrix3d tre_covariance(const Point<frames::Ct>& x) const;
  /// Root of its trace: the expected RMS target registration error at a point, mm.
  [[nodiscard]] double tre_rms_mm(const Point<frames::Ct>& x) const;
  /// Adds an error of another cause that shifts all points together, in any direction alike: by
  /// rms_mm RMS, >= 0; of one that is not a number nothing is known of the pose's error either.
  void widen(double rms_mm);
};

}  // namespace nav::registration
