// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/derived/error_estimate.hpp"

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace nav::render::derived {
namespace {

// Conjugate gradients in double on a diagonal matrix, whose eigenvalues and solution are known.
TEST(ErrorEstimateTest, FindsTheLeastEigenvalueAndWithItTheError) {
  constexpr int kSize = 40;
  constexpr double kLeast = 0.02;
  constexpr double kBelow = 2;  // Without M the residual leaps, which the estimate sees.
  constexpr double kAbove = 6;
  const Eigen::VectorXd matrix =
      Eigen::VectorXd::LinSpaced(kSize, std::log(kLeast), std::log(2.0)).array().exp();
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(kSize);
  const Eigen::VectorXd truth = b.cwiseQuotient(matrix);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(kSize);
  Eigen::VectorXd r = b;
  Eigen::VectorXd p = r;
  ErrorEstimate estimate;
  int judged = 0;
  for (int n = 0; n < 60 && (truth - x).norm() > 1e-6; ++n) {
    const double rr = r.squaredNorm();
    const double error = (truth - x).norm();
    if (n < ErrorEstimate::kDirections) {
      EXPECT_TRUE(std::isinf(estimate.error(rr))) << n;
    } else if (error < 0.1 * truth.norm()) {
      EXPECT_GT(estimate.error(rr), error / kBelow) << n;
      EXPECT_LT(estimate.error(rr), error * kAbove) << n;
      ++judged;
    }
    const Eigen::VectorXd ap = matrix.cwiseProduct(p);
    const double pap = p.dot(ap);
    estimate.add_step(rr, pap, p.squaredNorm());
    EXPECT_GT(estimate.least_eigenvalue(), kLeast * (1 - 1e-9)) << n;
    x += rr / pap * p;
    r -= rr / pap * ap;
    p = r + r.squaredNorm() / rr * p;
  }
  EXPECT_GT(judged, 5);
  EXPECT_NEAR(estimate.least_eigenvalue(), kLeast, 1e-4 * kLeast);
  estimate.restart();
  EXPECT_NEAR(estimate.least_eigenvalue(), kLeast, 1e-4 * kLeast) << "remains";
}

}  // namespace
}  // namespace nav::render::derived
