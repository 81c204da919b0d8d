// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/landmarks/landmarks.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "tests/registration/normal.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

constexpr double kSolvedToMm = 1e-10;
constexpr double kRoundingRad = 1e-7;  // acos near 1 loses half the digits.

std::vector<LandmarkPair> exact_pairs(const Eigen::Vector3d& offset_mm = Eigen::Vector3d::Zero()) {
  const std::vector<Eigen::Vector3d> points{{-60, 20, 10}, {55, -5, 30},  {0, 70, -40},
                                            {20, 10, 90},  {-30, -50, 5}, {40, 35, -70}};
  const auto truth = test::true_pose(offset_mm);
  std::vector<LandmarkPair> pairs;
  for (const auto& p : points) {
    const Point<frames::Reference> reference{p};
    pairs.push_back({"point " + std::to_string(pairs.size()), reference, truth * reference, 1.0});
  }
  return pairs;
}

TEST(LandmarksTest, FindsTheTrueTransform) {
  const auto result = register_landmarks(exact_pairs());
  ASSERT_TRUE(test::has_value(result));
  EXPECT_TRUE(
      test::is_near(result->ct_from_reference, test::true_pose(), kSolvedToMm, kRoundingRad));
  EXPECT_LT(result->fre_rms_mm, kSolvedToMm);
  EXPECT_LT(result->sigma_scale, kSolvedToMm);
  ASSERT_EQ(result->residuals.size(), 6u);
  for (const auto& residual : result->residuals) {
    EXPECT_LT(residual.leave_one_out_mm, kSolvedToMm) << residual.name;
  }
}

TEST(LandmarksTest, ThreePointsGiveAPoseButNoLeaveOneOutError) {
  auto pairs = exact_pairs();
  pairs.resize(3);
  const auto result = register_landmarks(pairs);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_TRUE(
      test::is_near(result->ct_from_reference, test::true_pose(), kSolvedToMm, kRoundingRad));
  EXPECT_TRUE(std::isnan(result->residuals[0].leave_one_out_mm));
}

TEST(LandmarksTest, DistantOriginsDoNotMatter) {
  const Eigen::Vector3d offset(1e4, -1e4, 1e4);
  constexpr double kTolerance = 1e-7;  // 1e4 mm with 16 digits, times the lever arm of 1e4 mm.
  const auto result = register_landmarks(exact_pairs(offset));
  ASSERT_TRUE(test::has_value(result));
  EXPECT_LT(test::cube_error_mm(result->ct_from_reference, test::true_pose(offset), offset),
            kTolerance);
}

TEST(LandmarksTest, PredictsTheTargetErrorOfNoisyPoints) {
  const auto pairs = exact_pairs();
  const auto truth = test::true_pose();
  const std::vector<double> sigmas{0.5, 0.5, 1.0, 1.0, 2.0, 1.5};
  const Point<frames::Reference> target{{30, -80, 60}};
  constexpr int kTrials = 20000;
  // The standard error of an RMS of 20000 draws is 0.5 %. Second-order terms are far smaller.
  constexpr double kRelative = 0.03;
  test::Normal normal(3);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double predicted_mm = 0;
  double scale2 = 0;
  Eigen::Matrix3d predicted;
  for (int trial = 0; trial < kTrials; ++trial) {
    auto noisy = pairs;
    for (std::size_t i = 0; i < noisy.size(); ++i) {
      noisy[i].sigma_mm = sigmas[i];
      noisy[i].ct.mm += sigmas[i] * normal.vector();
    }
    const auto result = register_landmarks(noisy);
    ASSERT_TRUE(test::has_value(result));
    const Eigen::Vector3d error = (result->ct_from_reference * target).mm - (truth * target).mm;
    scatter += error * error.transpose() / kTrials;
    scale2 += result->sigma_scale * result->sigma_scale / kTrials;
    if (trial == 0) {
      predicted_mm = result->tre_rms_mm(truth * target);
      predicted = result->tre_covariance(truth * target);
    }
  }
  EXPECT_NEAR(std::sqrt(scatter.trace()) / predicted_mm, 1.0, kRelative);
  EXPECT_LT((scatter - predicted).norm() / predicted.norm(), 3 * kRelative);
  EXPECT_NEAR(std::sqrt(scale2), 1.0, kRelative);  // Correct sigmas give a scale of 1.
}

TEST(LandmarksTest, AgreesWithFitzpatrickForEqualWeights) {
  // Fitzpatrick: TRE² = FLE²/N (1 + 1/3 Σ d²/f²), where d and f are the distances of the target and
  // of the points from the principal axes. Here these are the coordinate axes of an octahedron.
  // Each axis is at distance a from four of the six points, so f² = 4a²/6.
  const double a = 50;
  std::vector<LandmarkPair> pairs;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Eigen::Vector3d p = Eigen::Vector3d::Zero();
      p[axis] = sign * a;
      pairs.push_back({std::to_string(pairs.size()), {p}, {p}, 0.7});
    }
  }
  const auto result = register_landmarks(pairs);
  ASSERT_TRUE(test::has_value(result));
  const Point<frames::Ct> target{{30, 40, -20}};
  const double fle2 = 3 * 0.7 * 0.7;
  const double f2 = 4 * a * a / 6;
  const double d2 = 2 * target.mm.squaredNorm();  // Sum over the three axes.
  const double expected = std::sqrt(fle2 / 6 * (1 + d2 / f2 / 3));
  EXPECT_NEAR(result->tre_rms_mm(target), expected, 1e-9);
}

TEST(LandmarksTest, TrustsPairsWithASmallSigmaMore) {
  auto pairs = exact_pairs();
  pairs[0].ct.mm += Eigen::Vector3d(10, 0, 0);
  const auto equal = register_landmarks(pairs);
  pairs[0].sigma_mm = 100;
  const auto weighted = register_landmarks(pairs);
  ASSERT_TRUE(test::has_value(equal));
  ASSERT_TRUE(test::has_value(weighted));
  const double equal_error = test::cube_error_mm(equal->ct_from_reference, test::true_pose());
  const double error = test::cube_error_mm(weighted->ct_from_reference, test::true_pose());
  EXPECT_GT(equal_error, 1.0);
  // The weight of this pair is 1e-4 of the weight of the others.
  EXPECT_LT(error, 1e-3 * equal_error);
}

TEST(LandmarksTest, LeaveOneOutErrorIdentifiesTheBadPoint) {
  auto pairs = exact_pairs();
  pairs[2].ct.mm += Eigen::Vector3d(0, 12, 0);
  const auto result = register_landmarks(pairs);
  ASSERT_TRUE(test::has_value(result));
  // The other points are exact, so the fit without this point shows its whole error.
  EXPECT_NEAR(result->residuals[2].leave_one_out_mm, 12.0, 1e-9);
  EXPECT_LT(result->residuals[2].distance_mm, 11.0);
}

TEST(LandmarksTest, RejectsPointsThatDetermineNoPose) {
  const auto code = ErrorCode::kMalformedData;
  auto pairs = exact_pairs();
  EXPECT_TRUE(test::rejects(register_landmarks(std::span(pairs).first(2)), code,
                            {"at least 3", "found 2"}));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].reference.mm = Eigen::Vector3d(static_cast<double>(i) * 20, 5, 5);
  }
  EXPECT_TRUE(test::rejects(register_landmarks(pairs), code, {"Reference", "collinear"}));
  pairs = exact_pairs();
  for (auto& pair : pairs) pair.ct.mm = Eigen::Vector3d(1, 2, 3);
  EXPECT_TRUE(test::rejects(register_landmarks(pairs), code, {"Ct", "coincident"}));
}

TEST(LandmarksTest, RejectsInvalidPairsByName) {
  const auto code = ErrorCode::kMalformedData;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  auto pairs = exact_pairs();
  pairs[1].ct.mm.x() = nan;
  EXPECT_TRUE(test::rejects(register_landmarks(pairs), code, {"point 1", "Ct", "NaN"}));
  pairs = exact_pairs();
  pairs[4].reference.mm.z() = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(test::rejects(register_landmarks(pairs), code, {"point 4", "Reference"}));
  for (const double sigma : {0.0, -1.0, nan}) {
    pairs = exact_pairs();
    pairs[3].sigma_mm = sigma;
    EXPECT_TRUE(test::rejects(register_landmarks(pairs), code, {"point 3", "sigma"}));
  }
  pairs = exact_pairs();
  pairs[5].name = "point 0";
  EXPECT_TRUE(test::rejects(register_landmarks(pairs), code, {"point 0", "twice"}));
  pairs[5].name.clear();
  EXPECT_TRUE(test::rejects(register_landmarks(pairs), code, {"landmark 5", "name"}));
}

TEST(LandmarksTest, RejectsHugeCoordinatesAndTooManyPairs) {
  const auto code = ErrorCode::kMalformedData;
  auto pairs = exact_pairs();
  for (auto& pair : pairs) pair.ct.mm *= 1e200;  // The squares of these coordinates are infinite.
  EXPECT_TRUE(test::rejects(register_landmarks(pairs), code, {"point 0", "Ct", "1e7 mm"}));
  pairs = exact_pairs();
  pairs[2].reference.mm.y() = -2e7;
  EXPECT_TRUE(test::rejects(register_landmarks(pairs), code, {"point 2", "Reference", "-2e+07"}));
  const auto some = exact_pairs();
  pairs.clear();
  for (std::size_t i = 0; i < 1001; ++i) {
    pairs.push_back(some[i % some.size()]);
    pairs.back().name = std::to_string(i);
  }
  EXPECT_TRUE(test::rejects(register_landmarks(pairs), code, {"at most 1000", "found 1001"}));
}

TEST(LandmarksTest, RejectsAMirroredList) {
  auto pairs = exact_pairs();
  for (auto& pair : pairs) pair.ct.mm.x() = -pair.ct.mm.x();
  EXPECT_TRUE(test::rejects(register_landmarks(pairs), ErrorCode::kMalformedData, {"reflection"}));
}

TEST(LandmarksTest, NearlyPlanarNoisyPointsAreNotMirrored) {
  // Noise determines the sign of the third axis here. The result must be a rotation nevertheless.
  test::Normal normal(8);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<LandmarkPair> pairs;
    for (const auto& p : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(80, 0, 0),
                          Eigen::Vector3d(0, 80, 0), Eigen::Vector3d(70, 90, 0)}) {
      pairs.push_back({std::to_string(pairs.size()), {p}, {p + normal.vector()}, 1.0});
    }
    const auto result = register_landmarks(pairs);
    ASSERT_TRUE(test::has_value(result));
    EXPECT_LT(result->fre_rms_mm, 5.0);  // Five sigma.
  }
}

}  // namespace
}  // namespace nav::registration
