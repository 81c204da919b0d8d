// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/motion/phase_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nav/check.hpp"
#include "registration/pose_solver.hpp"

namespace nav::registration {

using Vec = Eigen::Vector3d;

Eigen::VectorXd phase_basis(double phase, Eigen::Index columns) {
  Eigen::VectorXd out(columns);
  out[0] = 1;
  for (Eigen::Index i = 1; i < columns; i += 2) {
    const double angle = 2 * std::numbers::pi * static_cast<double>((i + 1) / 2) * phase;
    out[i] = std::cos(angle);
    out[i + 1] = std::sin(angle);
  }
  return out;
}

Vector6d phase_twist(const Eigen::MatrixXd& series, const Eigen::VectorXd& basis) {
  Vector6d twist = series * basis;
  twist.head<3>() /= kRotationScaleMm;
  return twist;
}

PhaseMotion::PhaseMotion(const Pose& mean, const Vec& centre_ct_mm)
    : PhaseMotion(mean, centre_ct_mm, Eigen::MatrixXd::Zero(6, 1)) {}

PhaseMotion::PhaseMotion(const Pose& mean, const Vec& centre_ct_mm, Eigen::MatrixXd series)
    : mean_(mean), centre_(centre_ct_mm), series_(std::move(series)) {
  NAV_CHECK(series_.rows() == 6 && series_.cols() % 2 == 1, series_.rows(), series_.cols());
}

Pose PhaseMotion::ct_from_reference(double phase) const {
  return moved(mean_, centre_, phase_twist(series_, phase_basis(phase, series_.cols())));
}

PhaseMotion PhaseMotion::after(const Transform<frames::Ct, frames::Ct>& step) const {
  const Eigen::Matrix3d turn = step.rotation().toRotationMatrix();
  Eigen::MatrixXd series = series_;
  series.topRows<3>() = turn * series_.topRows<3>();
  series.bottomRows<3>() = turn * series_.bottomRows<3>();
  return {step * mean_, (step * Point<frames::Ct>{centre_}).mm, std::move(series)};
}

double PhaseMotion::amplitude_mm(const Point<frames::Ct>& at_mean) const {
  constexpr int kPhases = 32;
  const Point<frames::Reference> p = mean_.inverse() * at_mean;
  double longest = 0;
  for (int i = 0; i < kPhases; ++i) {
    const Vec a = (ct_from_reference(static_cast<double>(i) / kPhases) * p).mm;
    for (int j = 0; j < i; ++j) {
      const Vec b = (ct_from_reference(static_cast<double>(j) / kPhases) * p).mm;
      longest = std::max(longest, (a - b).norm());
    }
  }
  return longest;
}

}  // namespace nav::registration
