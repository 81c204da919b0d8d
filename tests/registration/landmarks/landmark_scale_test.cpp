// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/landmarks/landmark_scale.hpp"

#include <gtest/gtest.h>
#include <random>

#include "tests/registration/synthetic.hpp"

namespace nav::registration {
namespace {

/// Eight landmarks of a trunk; the Ct points multiplied by factors along Ct's axes, the Reference
/// points along Reference's.
std::vector<LandmarkPair> scaled_pairs(const Eigen::Vector3d& ct, const Eigen::Vector3d& reference,
                                       double noise_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const std::vector<Eigen::Vector3d> places = {{-70, -40, 10}, {65, -45, 30}, {0, 60, -20},
                                               {-50, 30, 80},  {55, 20, -75}, {10, -60, -60},
                                               {-20, 10, 45},  {30, 50, 60}};
  std::vector<LandmarkPair> pairs;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Eigen::Vector3d noise(normal(random), normal(random), normal(random));
    const auto p = test::true_pose().inverse() * Point<frames::Ct>{places[i]};
    pairs.push_back({"p" + std::to_string(i),
                     {reference.cwiseProduct(p.mm) + noise_mm * noise},
                     {ct.cwiseProduct(places[i])},
                     1});
  }
  return pairs;
}

TEST(LandmarkScaleTest, FindsEveryScaleFromThreeToTwentyTwoPercent) {
  for (const double percent : {-22.0, -18.0, -10.0, -3.0, 3.0, 5.0, 12.0, 22.0}) {
    const double factor = 1 + percent / 100;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      Eigen::Vector3d factors = Eigen::Vector3d::Ones();
      factors[axis] = factor;
      const auto found = landmark_scale(scaled_pairs(factors, {1, 1, 1}, 0.3, 5));
      ASSERT_TRUE(found.has_value()) << percent << ' ' << axis;
      EXPECT_EQ(found->axes, ScaledAxes::kCt);
      EXPECT_LT((found->factors - factors).norm(), 0.015) << found->factors.transpose();
      const std::string words = in_words(*found);
      EXPECT_NE(words.find("the points in Ct are"), std::string::npos) << words;
      EXPECT_NE(words.find(percent < 0 ? "close together along " : "far apart along "),
                std::string::npos)
          << words;
      EXPECT_NE(words.find(std::string("along ") + "xyz"[axis]), std::string::npos) << words;
    }
    const auto all =
        landmark_scale(scaled_pairs(factor * Eigen::Vector3d::Ones(), {1, 1, 1}, 0.3, 6));
    ASSERT_TRUE(all.has_value()) << percent;
    EXPECT_EQ(all->axes, ScaledAxes::kAll);
    EXPECT_NEAR(all->factors[0], factor, 0.01);
  }
}

TEST(LandmarkScaleTest, NamesTheFrameWhoseAxesAreScaled) {
  const auto found = landmark_scale(scaled_pairs({1, 1, 1}, {1, 0.82, 1}, 0.3, 7));
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->axes, ScaledAxes::kReference);
  EXPECT_NE(in_words(*found).find("the points in Reference are 18 % too close together along y"),
            std::string::npos)
      << in_words(*found);
}

TEST(LandmarkScaleTest, SaysNothingOfRightPointsAndOfOneStray) {
  int diagnosed = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    diagnosed += landmark_scale(scaled_pairs({1, 1, 1}, {1, 1, 1}, 1, seed)).has_value() ? 1 : 0;
  }
  EXPECT_LE(diagnosed, 1);
  auto pairs = scaled_pairs({1, 1, 1}, {1, 1, 1}, 0.3, 9);
  pairs[3].ct.mm.x() += 20;
  EXPECT_FALSE(landmark_scale(pairs).has_value());
  pairs = scaled_pairs({0.8, 1, 1}, {1, 1, 1}, 0.3, 9);
  pairs.resize(4);
  EXPECT_FALSE(landmark_scale(pairs).has_value());
}

}  // namespace
}  // namespace nav::registration
