// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/error_estimate.hpp"

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace nav::render::features {
namespace {

/// Conjugate gradients in double on a diagonal matrix whose eigenvalues and solution are known.
/// Calls see(n, estimate, r · r, |e|) before each step. Returns the final estimate.
template <class See>
ErrorEstimate solve_diagonal(const Eigen::VectorXd& matrix, const Eigen::VectorXd& b, int steps,
                             const See& see) {
  const Eigen::VectorXd truth = b.cwiseQuotient(matrix);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size());
  Eigen::VectorXd r = b;
  Eigen::VectorXd p = r;
  ErrorEstimate estimate;
  for (int n = 0; n < steps && (truth - x).norm() > 1e-6; ++n) {
    const double rr = r.squaredNorm();
    see(n, estimate, rr, (truth - x).norm());
    const Eigen::VectorXd ap = matrix.cwiseProduct(p);
    const double pap = p.dot(ap);
    estimate.add_step(rr, pap, p.squaredNorm());
    x += rr / pap * p;
    r -= rr / pap * ap;
    p = r + r.squaredNorm() / rr * p;
  }
  return estimate;
}

Eigen::VectorXd spread_evenly(int size, double least, double greatest) {
  return Eigen::VectorXd::LinSpaced(size, std::log(least), std::log(greatest)).array().exp();
}

TEST(ErrorEstimateTest, FindsTheSmallestEigenvalueAndTheError) {
  constexpr double kLeast = 0.02;
  constexpr double kBelow = 2;  // Without M the residual jumps, which affects the estimate.
  constexpr double kAbove = 6;
  const Eigen::VectorXd matrix = spread_evenly(40, kLeast, 2);
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(40);
  const double whole = b.cwiseQuotient(matrix).norm();
  int judged = 0;
  ErrorEstimate estimate = solve_diagonal(
      matrix, b, 60, [&](int n, const ErrorEstimate& so_far, double rr, double error) {
        EXPECT_GT(so_far.least_eigenvalue(), kLeast * (1 - 1e-9)) << n;
        if (n < ErrorEstimate::kDirections) {
          EXPECT_TRUE(std::isinf(so_far.error(rr))) << n;
        } else if (error < 0.1 * whole) {
          EXPECT_GT(so_far.error(rr), error / kBelow) << n;
          EXPECT_LT(so_far.error(rr), error * kAbove) << n;
          ++judged;
        }
      });
  EXPECT_GT(judged, 5);
  EXPECT_NEAR(estimate.least_eigenvalue(), kLeast, 1e-4 * kLeast);
  estimate.restart();
  EXPECT_NEAR(estimate.least_eigenvalue(), kLeast, 1e-4 * kLeast) << "remains";
}

// One small eigenvalue is found late. Until then its estimate is far too large.
TEST(ErrorEstimateTest, ExtrapolatesAnEigenvalueThatStillFalls) {
  Eigen::VectorXd matrix = spread_evenly(40, 0.2, 2);
  matrix[0] = 0.02;
  Eigen::VectorXd b = Eigen::VectorXd::Ones(40);
  b[0] = 0.3;
  double farthest = 0;
  solve_diagonal(matrix, b, 60, [&](int n, const ErrorEstimate& so_far, double rr, double error) {
    if (n >= ErrorEstimate::kDirections && error > 1e-3) {
      farthest = std::max(farthest, error / so_far.error(rr));
    }
  });
  EXPECT_LT(farthest, 4);  // Without the extrapolation, 9.2 is found.
}

}  // namespace
}  // namespace nav::render::features
