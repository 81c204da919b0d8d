// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/lc2_kernel.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace nav::registration {
namespace {

constexpr double kKernelRidge = 0.02;
// Float sums of about 100 centred products, compared with doubles.
constexpr double kFloatRelative = 2e-5;

/// Smooth artificial channels on a grid of 24 x 22 x 20 anisotropic texels.
CtChannels channels(bool constant = false) {
  CtChannels ct;
  ct.size = {24, 22, 20};
  ct.spacing_mm = {1.5, 2.0, 1.0};
  ct.origin_ct_mm = {3, 4, 5};
  ct.directions.setIdentity();
  for (int k = 0; k < ct.size[2]; ++k) {
    for (int j = 0; j < ct.size[1]; ++j) {
      for (int i = 0; i < ct.size[0]; ++i) {
        const double x = 0.3 * i + 0.13 * j - 0.21 * k;
        const double y = 0.17 * i - 0.29 * j + 0.11 * k;
        const auto f = [&](double phase) { return static_cast<float>(std::sin(x + phase * y)); };
        ct.texels.push_back(constant ? std::array<float, 4>{0.5f, 0, 0, 0}
                                     : std::array<float, 4>{f(1), f(2), f(-1), f(0.5)});
      }
    }
  }
  return ct;
}

struct TestPatch {
  std::vector<float> u;
  PlacedPatch placed;
};

/// The values u are noise with zero mean and unit norm. The patch lies obliquely inside the grid.
TestPatch oblique_patch(int side = 9, unsigned seed = 4) {
  TestPatch patch;
  std::mt19937 random(seed);
  const int n = side * side;
  Eigen::VectorXd u(n);
  for (int i = 0; i < n; ++i) u[i] = static_cast<double>(random()) / 4294967296.0;
  u.array() -= u.mean();
  u.normalize();
  for (int i = 0; i < n; ++i) patch.u.push_back(static_cast<float>(u[i]));
  // No sample lies on a texel border, where the interpolant has a kink.
  patch.placed = {.centre = {16.313, 20.117, 9.211},
                  .step_a = Eigen::Vector3d(1.0, 0.3, 0.1),
                  .step_b = Eigen::Vector3d(-0.2, 0.9, 0.4),
                  .beam = Eigen::Vector3d(-0.2, 0.9, 0.4).normalized(),
                  .side = side,
                  .u = {}};
  return patch;
}
PlacedPatch placed(const TestPatch& patch) {
  PlacedPatch p = patch.placed;
  p.u = patch.u;
  return p;
}

/// Trilinear value of a channel in doubles, directly from the definition.
double trilinear(const CtChannels& ct, const Eigen::Vector3d& y, std::size_t channel) {
  const Eigen::Vector3d index = y.cwiseQuotient(ct.spacing_mm);
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    std::array<int, 3> at{};
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const int last = ct.size[static_cast<std::size_t>(axis)] - 1;
      const double x = std::clamp(index[axis], 0.0, static_cast<double>(last));
      const int low = std::min(static_cast<int>(x), last - 1);
      const bool high = ((corner >> axis) & 1) != 0;
      at[static_cast<std::size_t>(axis)] = low + (high ? 1 : 0);
      weight *= high ? x - low : 1 - (x - low);
    }
    const auto offset = static_cast<std::size_t>((at[2] * ct.size[1] + at[1]) * ct.size[0] + at[0]);
    sum += weight * static_cast<double>(ct.texels[offset][channel]);
  }
  return sum;
}

/// Minimum over c of ‖u − Ac‖² + nλ²‖c‖², solved as an ordinary least-squares problem with stacked
/// rows.
double oracle(const CtChannels& ct, const PlacedPatch& patch, double ridge) {
  const int half = patch.side / 2;
  const int n = patch.side * patch.side;
  Eigen::MatrixXd a(n, 2);
  Eigen::VectorXd u(n);
  int row = 0;
  for (int b = -half; b <= half; ++b) {
    for (int i = -half; i <= half; ++i, ++row) {
      const Eigen::Vector3d y = patch.centre + i * patch.step_a + b * patch.step_b;
      const double q = patch.beam.x() * trilinear(ct, y, 1) + patch.beam.y() * trilinear(ct, y, 2) +
                       patch.beam.z() * trilinear(ct, y, 3);
      a(row, 0) = trilinear(ct, y, 0);
      a(row, 1) = std::sqrt(q * q + 0.01 * 0.01);
      u[row] = static_cast<double>(patch.u[static_cast<std::size_t>(row)]);
    }
  }
  a.rowwise() -= a.colwise().mean().eval();
  Eigen::MatrixXd stacked = Eigen::MatrixXd::Zero(n + 2, 2);
  stacked.topRows(n) = a;
  stacked.bottomRows(2) = std::sqrt(static_cast<double>(n)) * ridge * Eigen::Matrix2d::Identity();
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n + 2);
  right.head(n) = u;
  const Eigen::VectorXd c = stacked.householderQr().solve(right);
  return (right - stacked * c).squaredNorm();
}

/// Returns the patch after a twist [rotation | translation] about its centre.
PlacedPatch twisted(const PlacedPatch& patch, const Vector6d& twist) {
  PlacedPatch moved = patch;
  const Eigen::Quaterniond r = exp_rotation(twist.head<3>());
  moved.centre += twist.tail<3>();
  moved.step_a = r * patch.step_a;
  moved.step_b = r * patch.step_b;
  moved.beam = r * patch.beam;
  return moved;
}

TEST(Lc2KernelTest, ValueMatchesTheFormulaInDoubles) {
  const CtChannels ct = channels();
  for (const int side : {5, 7, 9, 11, 13}) {
    const TestPatch patch = oblique_patch(side, static_cast<unsigned>(side));
    const double expected = oracle(ct, placed(patch), kKernelRidge);
    EXPECT_NEAR(patch_cost(ct, placed(patch), kKernelRidge), expected, kFloatRelative) << side;
    EXPECT_EQ(patch_terms(ct, placed(patch), kKernelRidge).s,
              patch_cost(ct, placed(patch), kKernelRidge));
  }
}

TEST(Lc2KernelTest, ValueMatchesTheFormulaAcrossTheBorder) {
  const CtChannels ct = channels();
  TestPatch patch = oblique_patch();
  patch.placed.centre = {1.0, 2.0, 18.0};
  EXPECT_NEAR(patch_cost(ct, placed(patch), kKernelRidge), oracle(ct, placed(patch), kKernelRidge),
              kFloatRelative);
}

TEST(Lc2KernelTest, ValueMatchesTheFormulaFarOutside) {
  const CtChannels ct = channels();
  TestPatch patch = oblique_patch();
  for (const Eigen::Vector3d& centre :
       {Eigen::Vector3d(-40, 5, 6), Eigen::Vector3d(9, 1e5, 6), Eigen::Vector3d(8, 7, -1e8),
        Eigen::Vector3d(1e3, 1e4, 1e8)}) {
    patch.placed.centre = centre;
    EXPECT_NEAR(patch_cost(ct, placed(patch), kKernelRidge),
                oracle(ct, placed(patch), kKernelRidge), kFloatRelative)
        << centre.transpose();
  }
}

TEST(Lc2KernelTest, GradientMatchesCentralDifferencesOfTheOracle) {
  const CtChannels ct = channels();
  const TestPatch patch = oblique_patch(11, 2);
  const PatchTerms terms = patch_terms(ct, placed(patch), kKernelRidge);
  // The step is small because the interpolant has kinks at texel borders. Doubles allow it.
  constexpr double kStep = 1e-6;
  constexpr double kRelative = 1e-3;
  for (int i = 0; i < 6; ++i) {
    Vector6d step = Vector6d::Zero();
    step[i] = kStep;
    const double difference = (oracle(ct, twisted(placed(patch), step), kKernelRidge) -
                               oracle(ct, twisted(placed(patch), -step), kKernelRidge)) /
                              (2 * kStep);
    EXPECT_NEAR(terms.gradient[i], 0.5 * difference, kRelative * terms.gradient.norm()) << i;
  }
}

TEST(Lc2KernelTest, GradientMatchesAcrossTheBorder) {
  const CtChannels ct = channels();
  TestPatch patch = oblique_patch();
  patch.placed.centre = {1.013, 2.017, 17.011};
  const PatchTerms terms = patch_terms(ct, placed(patch), kKernelRidge);
  constexpr double kStep = 1e-6;
  constexpr double kRelative = 1e-3;
  for (int i = 0; i < 6; ++i) {
    Vector6d step = Vector6d::Zero();
    step[i] = kStep;
    const double difference = (oracle(ct, twisted(placed(patch), step), kKernelRidge) -
                               oracle(ct, twisted(placed(patch), -step), kKernelRidge)) /
                              (2 * kStep);
    EXPECT_NEAR(terms.gradient[i], 0.5 * difference, kRelative * terms.gradient.norm()) << i;
  }
}

/// Patch whose values u are exactly linear in the two channels.
TestPatch linear_patch(const CtChannels& ct, double on_f, double on_g) {
  TestPatch patch = oblique_patch(11);
  const PlacedPatch& p = patch.placed;
  Eigen::VectorXd u(p.side * p.side);
  int row = 0;
  for (int b = -p.side / 2; b <= p.side / 2; ++b) {
    for (int a = -p.side / 2; a <= p.side / 2; ++a, ++row) {
      const Eigen::Vector3d y = p.centre + a * p.step_a + b * p.step_b;
      const Eigen::Vector3d g(trilinear(ct, y, 1), trilinear(ct, y, 2), trilinear(ct, y, 3));
      const double q = p.beam.dot(g);
      u[row] = on_f * trilinear(ct, y, 0) + on_g * std::sqrt(q * q + 0.01 * 0.01);
    }
  }
  u.array() -= u.mean();
  u.normalize();
  for (int i = 0; i < u.size(); ++i) {
    patch.u[static_cast<std::size_t>(i)] = static_cast<float>(u[i]);
  }
  return patch;
}

TEST(Lc2KernelTest, IsZeroIfTheUltrasoundIsLinearInTheChannels) {
  const CtChannels ct = channels();
  constexpr double kTinyRidge = 1e-4;
  // Ridge bias λ²/variance, plus float rounding.
  constexpr double kZero = 1e-5;
  const TestPatch patch = linear_patch(ct, 1.3, -0.6);
  EXPECT_LT(patch_cost(ct, placed(patch), kTinyRidge), kZero);
  const PatchTerms terms = patch_terms(ct, placed(patch), kTinyRidge);
  EXPECT_LT(terms.gradient.norm(), 1e-3);
  // Away from this pose, the cost grows as the Gauss–Newton Hessian predicts.
  for (int i = 0; i < 6; ++i) {
    Vector6d step = Vector6d::Zero();
    step[i] = i < 3 ? 0.002 : 0.02;
    const double s = patch_cost(ct, twisted(placed(patch), step), kTinyRidge);
    const double predicted = step.dot(terms.hessian * step);
    EXPECT_GT(s, 1e-6);
    EXPECT_NEAR(s / predicted, 1.0, 0.2) << i;
  }
}

TEST(Lc2KernelTest, SignOfTheUltrasoundDoesNotMatter) {
  const CtChannels ct = channels();
  const TestPatch plus = oblique_patch();
  TestPatch minus = plus;
  for (float& value : minus.u) value = -value;
  EXPECT_EQ(patch_cost(ct, placed(plus), kKernelRidge),
            patch_cost(ct, placed(minus), kKernelRidge));
}

TEST(Lc2KernelTest, ConstantCtExplainsNothing) {
  const CtChannels ct = channels(true);
  const TestPatch patch = oblique_patch();
  const PatchTerms terms = patch_terms(ct, placed(patch), kKernelRidge);
  EXPECT_NEAR(terms.s, 1.0, kFloatRelative);
  EXPECT_EQ(terms.gradient.norm(), 0.0);
  EXPECT_EQ(terms.hessian.norm(), 0.0);
}

TEST(Lc2KernelTest, CollinearChannelsStayFinite) {
  CtChannels ct = channels();
  for (auto& texel : ct.texels) texel = {texel[0], 0, 5.0f + texel[0], 0};
  TestPatch patch = oblique_patch();
  patch.placed.beam = {0, 1, 0};
  const PatchTerms terms = patch_terms(ct, placed(patch), kKernelRidge);
  EXPECT_TRUE(std::isfinite(terms.s) && terms.gradient.allFinite() && terms.hessian.allFinite());
  EXPECT_NEAR(terms.s, oracle(ct, placed(patch), kKernelRidge), 1e-4);
}

TEST(Lc2KernelTest, NanNeverCountsAsAMatch) {
  CtChannels ct = channels();
  const TestPatch patch = oblique_patch();
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    CtChannels poisoned = ct;
    for (auto& texel : poisoned.texels) texel[0] = bad;
    EXPECT_TRUE(std::isnan(patch_cost(poisoned, placed(patch), kKernelRidge)));
    EXPECT_TRUE(std::isnan(patch_terms(poisoned, placed(patch), kKernelRidge).s));
  }
  TestPatch lost = patch;
  lost.placed.centre.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(patch_cost(ct, placed(lost), kKernelRidge)));
  lost.placed.centre.x() = 1e300;
  EXPECT_TRUE(std::isnan(patch_terms(ct, placed(lost), kKernelRidge).s));
}

TEST(Lc2KernelTest, FarOutsideTheCtNothingMatches) {
  const CtChannels ct = channels();
  TestPatch patch = oblique_patch();
  patch.placed.centre = {-2000, 2000, 2000};
  const PatchTerms terms = patch_terms(ct, placed(patch), kKernelRidge);
  EXPECT_NEAR(terms.s, 1.0, kFloatRelative);
  EXPECT_EQ(terms.gradient.norm(), 0.0);
}

}  // namespace
}  // namespace nav::registration
