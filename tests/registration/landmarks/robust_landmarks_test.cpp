// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/landmarks/robust_landmarks.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/support/matchers.hpp"
#include "tests/support/trials.hpp"

namespace nav::registration {
namespace {

using Pose = Transform<frames::Ct, frames::Reference>;

Pose truth() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.9, Eigen::Vector3d(1, -2, 3).normalized())),
          {40, -10, 200}};
}

/// Point pairs in a cube of 120 mm with noise of 0.5 mm per axis.
std::vector<LandmarkPair> pairs_of(int count, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  const auto noise = [&] {
    return 0.5 * std::sqrt(-2 * std::log(1 - uniform())) * std::cos(2 * M_PI * uniform());
  };
  std::vector<LandmarkPair> pairs;
  for (int i = 0; i < count; ++i) {
    const Point<frames::Reference> p{
        {120 * uniform() - 60, 120 * uniform() - 60, 120 * uniform() - 60}};
    const Eigen::Vector3d off(noise(), noise(), noise());
    pairs.push_back({std::to_string(i), p, {(truth() * p).mm + off}, 0.5});
  }
  return pairs;
}

double error_mm(const Pose& found) {
  const Point<frames::Reference> p{{10, 10, 10}};
  return (found * p - truth() * p).v.norm();
}

TEST(RobustLandmarksTest, WithoutOutliersTheResultIsTheClosedForm) {
  const auto pairs = pairs_of(8, 1);
  const auto plain = register_landmarks(pairs);
  const auto robust = register_landmarks_robustly(pairs);
  ASSERT_TRUE(test::has_value(plain));
  ASSERT_TRUE(test::has_value(robust));
  EXPECT_TRUE(robust->rejected.empty());
  EXPECT_EQ(robust->fit.ct_from_reference.matrix(), plain->ct_from_reference.matrix());
}

TEST(RobustLandmarksTest, SwappedNamesAreDetectedAndNamed) {
  auto pairs = pairs_of(8, 2);
  std::swap(pairs[2].ct, pairs[5].ct);
  const auto robust = register_landmarks_robustly(pairs);
  ASSERT_TRUE(test::has_value(robust));
  EXPECT_EQ(robust->rejected, (std::vector<std::string>{"2", "5"}));
  EXPECT_LT(error_mm(robust->fit.ct_from_reference), 1.0);  // Two sigmas of 0.5 mm.
}

TEST(RobustLandmarksTest, SwappedNamesAreNotReportedAsMirrored) {
  int looked_mirrored = 0;
  int found = 0;
  int called_mirrored = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    auto pairs = pairs_of(6, seed);
    std::swap(pairs[0].ct, pairs[1].ct);
    if (register_landmarks(pairs)) continue;
    ++looked_mirrored;
    const auto robust = register_landmarks_robustly(pairs);
    if (robust) {
      ++found;
      EXPECT_LE(error_mm(robust->fit.ct_from_reference), 3) << seed;
    } else if (robust.error().code != ErrorCode::kRefused) {
      ++called_mirrored;
    }
  }
  // Otherwise a correct pair was rejected, as one in a hundred is, and the rest is no majority. Or
  // four points lie so near a plane that as many agree with the mirrored pose.
  EXPECT_GE(looked_mirrored, 10);
  EXPECT_GE(found, 0.6 * looked_mirrored);
  EXPECT_LE(called_mirrored, 0.2 * looked_mirrored);
}

TEST(RobustLandmarksTest, AMirroredListWithAWrongPairIsReportedAsMirrored) {
  for (unsigned seed = 1; seed <= test::trials(20U); ++seed) {
    auto pairs = pairs_of(8, seed);
    for (auto& pair : pairs) pair.ct.mm.x() *= -1;
    pairs[seed % 8].ct.mm.y() += 40;
    const auto robust = register_landmarks_robustly(pairs);
    ASSERT_FALSE(robust.has_value()) << seed;
    if (robust.error().code != ErrorCode::kRefused) {
      EXPECT_NE(robust.error().message.find("mirrored"), std::string::npos) << seed;
    }
  }
}

TEST(RobustLandmarksTest, ToleratesJustBelowHalfOutliers) {
  for (unsigned seed = 1; seed <= test::trials(10U); ++seed) {
    auto pairs = pairs_of(11, seed);
    for (std::size_t i = 0; i < 5; ++i) {
      pairs[i].ct.mm += Eigen::Vector3d(15.0 + 7.0 * static_cast<double>(i), -20, 9);
    }
    const auto robust = register_landmarks_robustly(pairs);
    ASSERT_TRUE(test::has_value(robust)) << seed;
    // One correct pair in a hundred is rejected.
    EXPECT_GE(robust->rejected.size(), 5u);
    EXPECT_LE(robust->rejected.size(), 6u);
    EXPECT_LT(error_mm(robust->fit.ct_from_reference), 1.5) << seed;
  }
}

TEST(RobustLandmarksTest, RejectsAListWithoutAMajority) {
  auto pairs = pairs_of(8, 3);
  for (std::size_t i = 0; i < 5; ++i) {
    pairs[i].ct.mm += 30.0 * Eigen::Vector3d(std::sin(2.0 * static_cast<double>(i)),
                                             std::cos(3.0 * static_cast<double>(i)), 1);
  }
  EXPECT_TRUE(test::rejects(register_landmarks_robustly(pairs), ErrorCode::kRefused,
                            {"more than half of the 8 pairs", "'0'"}));
}

TEST(RobustLandmarksTest, RejectsFourPairsWithOneWrong) {
  auto pairs = pairs_of(4, 4);
  pairs[3].ct.mm.x() += 25;
  EXPECT_TRUE(test::rejects(register_landmarks_robustly(pairs), ErrorCode::kRefused,
                            {"at least 4", "found 3"}));
}

TEST(RobustLandmarksTest, RejectsWhatTheClosedFormRejects) {
  auto pairs = pairs_of(6, 5);
  for (auto& pair : pairs) pair.ct.mm.x() *= -1;  // A flipped axis.
  EXPECT_FALSE(register_landmarks_robustly(pairs).has_value());
  pairs = pairs_of(2, 6);
  EXPECT_TRUE(test::rejects(register_landmarks_robustly(pairs), ErrorCode::kMalformedData,
                            {"at least 3 pairs"}));
  pairs = pairs_of(5, 7);
  pairs[1].ct.mm.x() = std::nan("");
  EXPECT_FALSE(register_landmarks_robustly(pairs).has_value());
  EXPECT_TRUE(test::rejects(register_landmarks_robustly(pairs_of(5, 7), {.inlier_sigmas = 0}),
                            ErrorCode::kUsage, {"inlier_sigmas"}));
}

}  // namespace
}  // namespace nav::registration
