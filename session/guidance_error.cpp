// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/guidance_error.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "registration/twist.hpp"

namespace nav::session {
namespace {

using registration::cross_matrix;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Jacobian = Eigen::Matrix<double, 3, 6>;

/// Half width of the interval that holds a normal value with 95 %, in standard deviations.
constexpr double kInterval95 = 1.959964;

double largest_sigma(const Mat3& covariance) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

double sigma_along(const Mat3& covariance, const Vec3& direction) {
  return std::sqrt(std::max(0.0, direction.dot(covariance * direction)));
}

/// Standard deviation of the length of a vector whose error has a covariance.
double sigma_of_length(const Vec3& vector, const Mat3& covariance) {
  const double length = vector.norm();
  const double most = largest_sigma(covariance);
  return length > most ? sigma_along(covariance, vector / length) : most;
}

}  // namespace

GuidanceError guidance_error(const NeedlePlan& plan,
                             const Transform<frames::Ct, frames::Needle>& needle,
                             const KnownErrors& known) {
  GuidanceError error;
  const bool has_registration =
      known.registration.has_value() && known.registration->covariance.allFinite();
  const bool has_tracker = known.tracker_rms_mm.has_value() && std::isfinite(*known.tracker_rms_mm);
  (has_registration ? error.with : error.without).emplace_back("registration");
  (has_tracker ? error.with : error.without).emplace_back("tracker, position of the tip");
  for (const char* never :
       {"calibration of the needle", "bending of the needle", "motion of the organ"}) {
    error.without.emplace_back(never);
  }
  if (!has_registration && !has_tracker) return error;

  const Vec3 tip = (needle * Point<frames::Needle>{Vec3::Zero()}).mm;
  const Vec3 axis = (needle * Direction<frames::Needle>{Vec3::UnitZ()}).v.normalized();
  const Vec3 path = (plan.target_ct.mm - plan.entry_ct.mm).normalized();
  const Vec3 to_target = plan.target_ct.mm - tip;
  const double depth = to_target.dot(axis);

  // Errors of the tip and of the axis by the twist of the registration [rotation | translation].
  Eigen::Matrix<double, 6, 6> twist = Eigen::Matrix<double, 6, 6>::Zero();
  Vec3 centre = tip;
  if (has_registration) {
    twist = known.registration->covariance;
    centre = known.registration->centre_ct.mm;
  }
  Jacobian of_tip;
  of_tip << -cross_matrix(tip - centre), Mat3::Identity();
  Jacobian of_axis;
  of_axis << -cross_matrix(axis), Mat3::Zero();
  // RMS over three directions.
  const double tracker = has_tracker ? *known.tracker_rms_mm * *known.tracker_rms_mm / 3 : 0;
  const auto covariance = [&](const Jacobian& by_twist, const Mat3& by_tip) -> Mat3 {
    return by_twist * twist * by_twist.transpose() + tracker * by_tip * by_tip.transpose();
  };

  error.tip_to_target_mm =
      kInterval95 * sigma_of_length(to_target, covariance(-of_tip, -Mat3::Identity()));
  error.tip_mm = kInterval95 * largest_sigma(covariance(of_tip, Mat3::Identity()));
  // depth = d . n, and lateral = |d - (d . n) n|.
  const Eigen::Matrix<double, 1, 6> of_depth =
      -axis.transpose() * of_tip + to_target.transpose() * of_axis;
  error.along_axis_mm =
      kInterval95 *
      std::sqrt(std::max(0.0, (of_depth * twist * of_depth.transpose()).value() + tracker));
  const Mat3 across = Mat3::Identity() - axis * axis.transpose();
  const Jacobian of_lateral = across * (-of_tip - depth * of_axis);
  error.lateral_mm =
      kInterval95 * sigma_of_length(across * to_target, covariance(of_lateral, -across));
  if (has_registration) {
    // The error of the angle: that of the axis, in the plane of axis and path.
    const Mat3 of_direction = of_axis * twist * of_axis.transpose();
    const Vec3 aside = path.dot(axis) * axis - path;
    error.angle_to_plan_rad = kInterval95 * sigma_of_length(aside, of_direction);
  }
  return error;
}

}  // namespace nav::session
