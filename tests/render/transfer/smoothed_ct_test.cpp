// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/smoothed_ct.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "tests/render/scene_support.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

constexpr int kSmoothSide = 25;

TEST(SmoothedCtTest, AnImpulseBecomesTheGaussianInMillimetres) {
  const Eigen::Vector3d spacing(1, 2, 0.5);
  constexpr double kSigmaMm = 1.5;
  const auto ct = test::make_volume(
      test::centred_grid({kSmoothSide, kSmoothSide, kSmoothSide}, spacing),
      [](int i, int j, int k) { return i == 12 && j == 12 && k == 12 ? 30000 : 0; });
  const auto smooth = *smoothed_for_gradients(ct, kSigmaMm, 0);
  const auto weight = [&](int axis, int d) {
    const double sigma = kSigmaMm / spacing[axis];
    double sum = 0;
    const int radius = static_cast<int>(std::ceil(3 * sigma));
    for (int n = -radius; n <= radius; ++n) sum += std::exp(-0.5 * n * n / (sigma * sigma));
    return std::abs(d) > radius ? 0 : std::exp(-0.5 * d * d / (sigma * sigma)) / sum;
  };
  for (const Eigen::Vector3i& d : {Eigen::Vector3i(0, 0, 0),
                                   {1, 0, 0},
                                   {0, 1, 0},
                                   {0, 0, 1},
                                   {2, 1, 3},
                                   {4, 0, 0},
                                   {0, 3, 0}}) {
    const auto at = static_cast<std::size_t>(
        ((12 + d.z()) * kSmoothSide + 12 + d.y()) * kSmoothSide + 12 + d.x());
    constexpr double kRounded = 0.51;  // Values are whole HU.
    EXPECT_NEAR(smooth->values()[at],
                30000 * weight(0, d.x()) * weight(1, d.y()) * weight(2, d.z()), kRounded)
        << d.transpose();
  }
}

TEST(SmoothedCtTest, KeepsConstantsAtTheBorderAndTheVolumeItselfWithoutSmoothing) {
  const auto flat =
      test::make_volume(test::centred_grid({5, 4, 1}, {1, 1, 1}), [](int, int, int) { return 77; });
  const auto smooth = *smoothed_for_gradients(flat, 3, 0);
  for (const auto v : smooth->values()) EXPECT_EQ(v, 77);
  EXPECT_EQ(*smoothed_for_gradients(flat, 0, 0), flat);
  for (const double sigma : {-1.0, 20.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(test::rejects(smoothed_for_gradients(flat, sigma, 0), ErrorCode::kUsage,
                              {"smoothing", "0 to 20 mm"}));
  }
}

TEST(SmoothedCtTest, DoesNotDependOnTheNumberOfThreads) {
  const auto ct = test::make_volume(
      test::centred_grid({19, 17, 23}, {1, 1.3, 0.7}),
      [](int i, int j, int k) { return (i * 7919 + j * 104729 + k * 1299709) % 2001 - 1000; });
  const auto one = *smoothed_for_gradients(ct, 1.1, 1);
  const auto many = *smoothed_for_gradients(ct, 1.1, 5);
  EXPECT_TRUE(std::equal(one->values().begin(), one->values().end(), many->values().begin()));
}

}  // namespace
}  // namespace nav::render
