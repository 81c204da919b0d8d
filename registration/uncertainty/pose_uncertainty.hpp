// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "nav/transform.hpp"

namespace nav::registration {

/// Covariance of an estimated ct_from_reference. The true map is the estimate followed by exp(ω)
/// about centre_ct and the translation t: p = c + exp(ω)(p̂ − c) + t, all in Ct.
struct PoseUncertainty {
  Point<frames::Ct> centre_ct;             ///< c, mm.
  Eigen::Matrix<double, 6, 6> covariance;  ///< [rotation rad | translation mm], symmetric, >= 0.

  /// Covariance of a mapped point to first order, mm²: J Σ Jᵀ with J = [−[x − c]ₓ | I].
  [[nodiscard]] Eigen::Matrix3d tre_covariance(const Point<frames::Ct>& x) const;
  /// Square root of its trace: the expected RMS target registration error at a point, mm.
  [[nodiscard]] double tre_rms_mm(const Point<frames::Ct>& x) const;
  /// Adds an independent error that shifts all points together, equally in all directions: rms_mm
  /// RMS, >= 0. A NaN makes the error of the pose unknown too.
  void widen(double rms_mm);
};

}  // namespace nav::registration
