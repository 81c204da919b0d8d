// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "nav/transform.hpp"

/// Small motions of a pose. A twist is [rotation | translation]: p' = c + exp(ω)(p − c) + t.
namespace nav::registration {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The matrix [v]ₓ with [v]ₓ w = v × w.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Exponential of a rotation vector, rad.
inline Eigen::Quaterniond exp_rotation(const Eigen::Vector3d& omega) {
  const double angle = omega.norm();
  // Below this angle sin(a/2)/a equals 1/2 to the last bit.
  constexpr double kTinyRad = 1e-9;
  const double k = angle < kTinyRad ? 0.5 : std::sin(0.5 * angle) / angle;
  Eigen::Quaterniond q;
  q.w() = std::cos(0.5 * angle);
  q.vec() = k * omega;
  return q.normalized();
}

/// Left Jacobian of SO(3): exp(ω + dω) = exp(J dω) exp(ω) to first order.
inline Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& omega) {
  const double angle2 = omega.squaredNorm();
  const double angle = std::sqrt(angle2);
  // Taylor series below this angle: the closed forms lose digits as 1 − cos does.
  constexpr double kSmallRad = 1e-4;
  const double a = angle < kSmallRad ? 0.5 - angle2 / 24 : (1 - std::cos(angle)) / angle2;
  const double b =
      angle < kSmallRad ? 1.0 / 6 - angle2 / 120 : (angle - std::sin(angle)) / (angle2 * angle);
  const Eigen::Matrix3d k = cross_matrix(omega);
  return Eigen::Matrix3d::Identity() + a * k + b * k * k;
}

/// Applies a twist [rad | mm] about a centre in Ct after a pose.
inline Transform<frames::Ct, frames::Reference> moved(
    const Transform<frames::Ct, frames::Reference>& pose, const Eigen::Vector3d& centre_ct_mm,
    const Vector6d& twist) {
  const Eigen::Quaterniond r = exp_rotation(twist.head<3>());
  const Eigen::Vector3d t =
      centre_ct_mm + r * (pose.translation_mm() - centre_ct_mm) + twist.tail<3>();
  return {(r * pose.rotation()).normalized(), t};
}

}  // namespace nav::registration
