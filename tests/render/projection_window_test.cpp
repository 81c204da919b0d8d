// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/projection_window.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>

#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

constexpr int kSide = 48;

/// A window from the front along y. Parallel rays see the whole volume and the space beside it.
ProjectionWindow window_of(Projection projection, const std::function<int(int, int, int)>& value) {
  const auto ct = test::make_volume(test::centred_grid({kSide, kSide, kSide}, {1, 1, 1}), value);
  Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(200, 60, true));
  scene.projection = projection;
  scene.plane = test::upright_plane(test::grey_image(20, 16, 120), 1, {0, 0, 8});
  const auto found = window_of_projection(scene);
  EXPECT_TRUE(test::has_value(found));
  return *found;
}

double black(const ProjectionWindow& found) {
  return found.window.level_hu - found.window.width_hu / 2;
}
double white(const ProjectionWindow& found) {
  return found.window.level_hu + found.window.width_hu / 2;
}

/// Soft tissue in air, brighter to the left, with a rod of bone along z.
int body(int i, int j, int) {
  const double x = i - kSide / 2;
  const double y = j - kSide / 2;
  if (std::hypot(x, y) > 0.4 * kSide) return -1000;
  return std::hypot(x - 5, y) < 3 ? 800 : 40 + i;
}

constexpr double kTwoDigitsHu = 60;

TEST(ProjectionWindowTest, AMaximumGetsAWindowFromTissueToBone) {
  const auto found = window_of(Projection::kMaximum, body);
  EXPECT_FALSE(found.only_air);
  EXPECT_FALSE(found.one_value);
  EXPECT_GT(black(found), -200) << "air is left out";
  EXPECT_LT(black(found), 100);
  EXPECT_NEAR(white(found), 800, kTwoDigitsHu);
}

TEST(ProjectionWindowTest, AMeanGetsAWindowOfTheMeansOfWholeRays) {
  const auto found = window_of(Projection::kMean, body);
  EXPECT_FALSE(found.one_value);
  // A ray through the rod has 6 of 48 parts bone. At each side 8 parts, half as much again, are
  // air.
  EXPECT_LT(white(found), 200);
  EXPECT_GT(white(found), -300);
  EXPECT_LT(black(found), -300);
  EXPECT_GE(black(found), -960);
}

TEST(ProjectionWindowTest, AMinimumThroughAirReportsOnlyAir) {
  const auto found = window_of(Projection::kMinimum, body);
  EXPECT_TRUE(found.only_air);
  EXPECT_GT(found.window.width_hu, 0);
}

TEST(ProjectionWindowTest, AMinimumInACroppedCtGetsTheWindowOfTheLung) {
  const auto lung = [](int i, int j, int k) {
    const bool inside = std::hypot(i - 24, j - 24, k - 24) < 12;
    return inside ? -850 : (i + j + k) % 7 + 40;
  };
  const auto found = window_of(Projection::kMinimum, lung);
  EXPECT_FALSE(found.only_air);
  EXPECT_NEAR(black(found), -850, kTwoDigitsHu);
  EXPECT_NEAR(white(found), 40, kTwoDigitsHu);
}

TEST(ProjectionWindowTest, OtherValuesGetAWindowFromTheDarkestToTheBrightest) {
  const auto mask = [](int i, int, int) { return i < kSide / 2 ? 1 : 0; };
  for (const auto projection : {Projection::kMaximum, Projection::kMinimum, Projection::kMean}) {
    const auto found = window_of(projection, mask);
    EXPECT_EQ(found.window.level_hu, 0.5);
    EXPECT_EQ(found.window.width_hu, 1);
    EXPECT_FALSE(found.one_value);
  }
  const auto mr = [](int i, int, int k) { return 4 * i + 20 * k; };
  const auto found = window_of(Projection::kMaximum, mr);
  constexpr double kShareLeftOut = 0.1;  // Share of the range. Two hundredths of the rays are left
                                         // out, with an accuracy of two digits.
  EXPECT_NEAR(black(found), 0, kShareLeftOut * 24 * kSide);
  EXPECT_NEAR(white(found), 24 * (kSide - 1), kShareLeftOut * 24 * kSide);
}

TEST(ProjectionWindowTest, OneValueIsReported) {
  const auto found = window_of(Projection::kMaximum, [](int, int, int) { return 7; });
  EXPECT_TRUE(found.one_value);
  EXPECT_EQ(found.window.level_hu, 7);
  EXPECT_GT(found.window.width_hu, 0);
}

}  // namespace
}  // namespace nav::render
