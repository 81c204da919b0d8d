// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/plane_visibility.hpp"

#include <gtest/gtest.h>

#include "tests/render/scene_support.hpp"

namespace nav::app {
namespace {

/// A plane in the middle of a cube of one value, drawn by blood and by tissue.
render::Scene plane_in_cube(double blood_opacity, double tissue_opacity) {
  const auto ct = test::make_volume(test::centred_grid({40, 40, 40}, {1, 1, 1}),
                                    [](int, int, int) { return 300; });
  const auto flat = [](double opacity) {
    return std::vector<render::TransferNode>{{0, {1, 1, 1}, opacity, 1},
                                             {600, {1, 1, 1}, opacity, 1}};
  };
  const auto transfer = render::TransferFunction::blend(
      "test", {{"vessels", flat(blood_opacity), {}}, {"tissue", flat(tissue_opacity), {}}});
  render::Scene scene = test::plain_scene(ct, *transfer, test::frontal(120, 50, true));
  scene.plane = test::upright_plane(test::grey_image(20, 16, 120), 1, {0, 0, 0});
  scene.needle = test::needle({0, 0, 0}, {20, -30, 20});
  return scene;
}

TEST(PlaneVisibilityTest, APlaneInClearTissueIsSeenWhole) {
  const auto found = plane_visibility(plane_in_cube(0, 0));
  ASSERT_TRUE(test::has_value(found));
  EXPECT_NEAR(found->share, 1, 1e-3);
  EXPECT_TRUE(hidden_plane_words(*found).empty());
}

TEST(PlaneVisibilityTest, TheShareIsTheLightThatPassesTheVolume) {
  // 20 mm of 3 % for each mm.
  const auto found = plane_visibility(plane_in_cube(0.03, 0.0));
  ASSERT_TRUE(test::has_value(found));
  EXPECT_NEAR(found->share, std::pow(0.97, 20), 0.02);
}

TEST(PlaneVisibilityTest, NamesTheComponentThatHidesAndWhatHelps) {
  const auto found = plane_visibility(plane_in_cube(0.3, 0.01));
  ASSERT_TRUE(test::has_value(found));
  EXPECT_LT(found->share, 0.01);
  EXPECT_EQ(found->hidden, "vessels");
  EXPECT_NEAR(found->without, std::pow(0.99, 20), 0.02);
  const std::string words = hidden_plane_words(*found);
  for (const char* part : {"0 % of its light", "'vessels'", "--importance vessels:-1024:3071=0.5",
                           "--cutaway-thresholds 0 1"}) {
    EXPECT_NE(words.find(part), std::string::npos) << words;
  }
}

TEST(PlaneVisibilityTest, TwoComponentsThatEachHideItAreNotNamed) {
  const auto found = plane_visibility(plane_in_cube(0.3, 0.3));
  ASSERT_TRUE(test::has_value(found));
  EXPECT_LT(found->share, 0.01);
  EXPECT_TRUE(found->hidden.empty()) << found->hidden;
}

TEST(PlaneVisibilityTest, WithoutALivePlaneNothingIsHidden) {
  render::Scene scene = plane_in_cube(0.5, 0.5);
  scene.plane->safety = {SafetyState::kStale, "old"};
  EXPECT_EQ(plane_visibility(scene)->share, 1);
  scene.plane.reset();
  EXPECT_EQ(plane_visibility(scene)->share, 1);
}

}  // namespace
}  // namespace nav::app
