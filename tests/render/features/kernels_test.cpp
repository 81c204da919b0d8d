// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/kernels.hpp"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "render/features/gaussian_taps.hpp"

namespace nav::render::features {
namespace {

using Values = std::array<double, 3>;

/// Eigenvalues of many matrices in ascending order, computed by a set of kernels.
std::vector<Values> solve(const Kernels& set, const std::vector<Eigen::Matrix3d>& matrices) {
  const int count = padded(static_cast<int>(matrices.size()));
  std::array<std::vector<float>, 6> h;
  std::array<std::vector<float>, 3> out;
  for (auto& row : h) row.resize(static_cast<std::size_t>(count));
  for (auto& row : out) row.resize(static_cast<std::size_t>(count));
  for (std::size_t n = 0; n < matrices.size(); ++n) {
    const Eigen::Matrix3f m = matrices[n].cast<float>();
    const float parts[6] = {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)};
    for (std::size_t p = 0; p < 6; ++p) h[p][n] = parts[p];
  }
  set.eigenvalues({h[0].data(), h[1].data(), h[2].data(), h[3].data(), h[4].data(), h[5].data()},
                  out[0].data(), out[1].data(), out[2].data(), count);
  std::vector<Values> values;
  for (std::size_t n = 0; n < matrices.size(); ++n)
    values.push_back({out[0][n], out[1][n], out[2][n]});
  return values;
}

Eigen::Matrix3d rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

/// Returns a matrix that is exactly symmetric and rounded to float, so that both solvers get the
/// same matrix.
Eigen::Matrix3d with_eigenvalues(const Eigen::Vector3d& values, std::mt19937& random) {
  const Eigen::Matrix3d r = rotation(random);
  const Eigen::Matrix3d m = r * values.asDiagonal() * r.transpose();
  return (0.5 * (m + m.transpose())).cast<float>().cast<double>();
}

const std::array<const Kernels*, 2>& sets() {
  static const std::array<const Kernels*, 2> both{&kernels(), &portable_kernels()};
  return both;
}

TEST(EigenvaluesTest, AgreeWithTheIterativeSolverToFloatPrecision) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Matrix3d> matrices;
  for (int n = 0; n < 4000; ++n) {
    matrices.push_back(with_eigenvalues({normal(random), normal(random), normal(random)}, random));
    // Pairs and triples of eigenvalues that are equal or nearly equal.
    const double near = std::pow(10, -1 - 7 * (n % 8) / 8.0);
    matrices.push_back(with_eigenvalues({1, 1 + near, -0.3}, random));
    matrices.push_back(with_eigenvalues({-1, -1, near}, random));
    matrices.push_back(with_eigenvalues({2, 2 + near, 2 - near}, random));
    matrices.push_back(with_eigenvalues({near, 1e4, 1e4}, random));
  }
  for (const Kernels* set : sets()) {
    const auto found = solve(*set, matrices);
    double worst = 0;
    for (std::size_t n = 0; n < matrices.size(); ++n) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> truth(matrices[n]);
      for (int e = 0; e < 3; ++e) {
        worst = std::max(worst,
                         std::abs(found[n][static_cast<std::size_t>(e)] - truth.eigenvalues()[e]) /
                             matrices[n].norm());
      }
    }
    EXPECT_LT(worst, 8e-7) << set->name;
  }
}

TEST(EigenvaluesTest, AreCorrectForDiagonalZeroAndEqualMatrices) {
  const std::vector<Eigen::Matrix3d> matrices{
      Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Identity(), -7 * Eigen::Matrix3d::Identity(),
      Eigen::Vector3d(1e-30, 0, 0).asDiagonal(), Eigen::Vector3d(3, -1, 2).asDiagonal()};
  for (const Kernels* set : sets()) {
    const auto found = solve(*set, matrices);
    for (std::size_t e = 0; e < 3; ++e) {
      EXPECT_EQ(found[0][e], 0);
      EXPECT_NEAR(found[1][e], 1, 2e-7);
      EXPECT_NEAR(found[2][e], -7, 1e-6);
      EXPECT_NEAR(found[3][e], 0, 1e-29);
      EXPECT_NEAR(found[4][e], (Values{-1, 2, 3})[e], 2e-6);
    }
  }
}

TEST(GaussianTapsTest, AreExactForConstantsLinesAndParabolas) {
  for (const double sigma : {1e-3, 0.05, 0.3, 0.5, 1.0, 2.7, 9.0}) {
    const GaussianTaps taps = gaussian_taps(sigma, 4);
    double sum = taps.smooth[0], bends = taps.bend[0], slope = 0, second = 0;
    for (std::size_t k = 1; k < taps.smooth.size(); ++k) {
      const auto at = static_cast<double>(k);
      sum += 2 * taps.smooth[k];
      slope += 2 * at * taps.slope[k];
      bends += 2 * taps.bend[k];
      second += 2 * at * at * taps.bend[k];
    }
    EXPECT_NEAR(sum, 1, 1e-14) << sigma;
    EXPECT_NEAR(slope, 1, 1e-14) << sigma;
    EXPECT_NEAR(bends, 0, 1e-14) << sigma;
    EXPECT_NEAR(second, 2, 1e-13) << sigma;
  }
}

TEST(GaussianTapsTest, ATinySigmaGivesCentralDifferences) {
  const GaussianTaps taps = gaussian_taps(1e-3, 4);
  EXPECT_EQ(taps.radius, 1);
  EXPECT_DOUBLE_EQ(taps.slope[1], 0.5);
  EXPECT_DOUBLE_EQ(taps.bend[1], 1);
  EXPECT_DOUBLE_EQ(taps.bend[0], -2);
  EXPECT_DOUBLE_EQ(taps.smooth[0], 1);
}

TEST(GaussianTapsTest, SquaresOfASigmaMayUnderflow) {
  for (const double sigma : {1e-150, 1e-170, 1e-300, 5e-324}) {
    const GaussianTaps taps = gaussian_taps(sigma, 4);
    EXPECT_EQ(taps.slope[1], 0.5) << sigma;
    EXPECT_EQ(taps.bend[1], 1) << sigma;
    EXPECT_EQ(taps.bend[0], -2) << sigma;
    EXPECT_EQ(taps.smooth[0], 1) << sigma;
    EXPECT_EQ(taps.smooth[1], 0) << sigma;
  }
}

}  // namespace
}  // namespace nav::render::features
