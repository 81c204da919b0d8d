// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/uncertainty/pose_uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include "nav/check.hpp"
#include "registration/twist.hpp"

namespace nav::registration {

Eigen::Matrix3d PoseUncertainty::tre_covariance(const Point<frames::Ct>& x) const {
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian.leftCols<3>() = -cross_matrix(x.mm - centre_ct.mm);
  jacobian.rightCols<3>().setIdentity();
  return jacobian * covariance * jacobian.transpose();
}

double PoseUncertainty::tre_rms_mm(const Point<frames::Ct>& x) const {
  return std::sqrt(std::max(tre_covariance(x).trace(), 0.0));
}

void PoseUncertainty::widen(double rms_mm) {
  NAV_CHECK(!(rms_mm < 0), rms_mm);
  covariance.bottomRightCorner<3, 3>().diagonal().array() += rms_mm * rms_mm / 3;
}

}  // namespace nav::registration
