// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <gtest/gtest.h>

#include "render/predicates/shading_source.hpp"
#include "render/predicates/volume_scene.hpp"
#include "render/scene_compare.hpp"
#include "render/skipping/coarse_volumes.hpp"
#include "tests/render/predicates/predicate_scenes.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;

constexpr int kBallEdge = 41;
constexpr double kBallRadius = 14;  // Voxels of 1 mm.

/// A soft-edged ball of intensity 200 in darkness, drawn by one predicate.
PredicateVolume ball_volume() {
  const auto ultrasound = test::make_volume(
      test::centred_grid({kBallEdge, kBallEdge, kBallEdge}, {1, 1, 1}), [](int i, int j, int k) {
        const double r = Eigen::Vector3d(i - 20, j - 20, k - 20).norm();
        return static_cast<int>(200 * std::clamp((kBallRadius - r) / 4 + 0.5, 0.0, 1.0));
      });
  PredicateVolume volume{"ball", ultrasound, {}};
  volume.predicates.model = test::model_of({{E::kind("intensity", {0.05, 1e6}), 1}});
  volume.predicates.opacity_length_mm = 0.5;
  return volume;
}

Scene shaded_scene(double smoothing_mm) {
  PredicateVolume volume = ball_volume();
  auto shading =
      shading_of_predicates(*volume.ultrasound, {}, smoothing_mm, kUsualFullGradientPerMm, 1);
  EXPECT_TRUE(test::has_value(shading));
  volume.predicates.shading = *std::move(shading);
  Scene scene = predicate_scene(volume, volume.predicates.model, 64, 48);
  scene.camera.orthographic = true;
  scene.camera.orthographic_height_mm = 40;
  return scene;
}

float luminance(const RenderedImage& image, int x, int y) { return image.pixels.at(x, y).g; }

TEST(PredicateShadingTest, ASurfaceSeenEdgeOnIsDarkerByTheCosine) {
  const Scene scene = shaded_scene(1);
  Scene plain = scene;
  plain.predicates->shading.reset();
  const auto engine = make_reference_engine();
  const RenderedImage shaded = test::draw(*engine, scene);
  const RenderedImage flat = test::draw(*engine, plain);
  // 40 mm over 48 rows: the ball's rim is 16.8 pixels from the middle.
  const float middle = luminance(shaded, 32, 24) / luminance(flat, 32, 24);
  const float rim = luminance(shaded, 46, 24) / luminance(flat, 46, 24);
  EXPECT_GT(middle, 1.0F) << "diffuse and ambient light sum to 1, and the gloss is added";
  // Cosine at 14 pixels of 16.8: 0.55; the gloss is below 1e-5.
  EXPECT_NEAR(rim, 0.3 + 0.7 * 0.55, 0.1);
}

TEST(PredicateShadingTest, OpacityDoesNotDependOnShading) {
  const Scene scene = shaded_scene(1);
  Scene plain = scene;
  plain.predicates->shading.reset();
  plain.background_rgb = {0, 0, 0};
  Scene black = scene;
  black.predicates->shading->ambient = black.predicates->shading->diffuse = 0;
  black.predicates->shading->specular = 0;
  black.predicates->shading->full_gradient_per_mm = 1e-6;
  black.background_rgb = {1, 1, 1};
  Scene plain_white = plain;
  plain_white.background_rgb = {1, 1, 1};
  const auto engine = make_reference_engine();
  const RenderedImage a = test::draw(*engine, plain);
  const RenderedImage b = test::draw(*engine, plain_white);
  const RenderedImage c = test::draw(*engine, black);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      // Light of the background that passes, without shading and with black shading.
      const float passes = luminance(b, x, y) - luminance(a, x, y);
      EXPECT_GE(luminance(c, x, y), passes - 1e-6F) << x << ", " << y;
      if (std::hypot(x - 32, y - 24) < 12) {
        EXPECT_NEAR(luminance(c, x, y), passes, 0.02F);
      }
    }
  }
}

TEST(PredicateShadingTest, TheSourceHasTheShareOfWhiteAndTheFullGradient) {
  const auto ramp = test::make_volume(test::centred_grid({31, 5, 5}, {0.5, 1, 1}),
                                      [](int i, int, int) { return 40 + 5 * i; });
  const auto shading = shading_of_predicates(*ramp, {40, 240}, 1, 0.1, 1);
  ASSERT_TRUE(test::has_value(shading));
  EXPECT_DOUBLE_EQ(shading->full_gradient_per_mm, 1600);
  // 5 of 200 for each voxel of 0.5 mm: 0.05 of white per mm, half the full gradient.
  const auto row = shading->source->values();
  EXPECT_NEAR(row[16] - row[14], 800, 1);
}

TEST(PredicateShadingTest, TheBytesDoNotDependOnTheThreads) {
  const auto volume = ball_volume();
  const auto one = shading_of_predicates(*volume.ultrasound, {}, 1.5, 0.1, 1);
  const auto many = shading_of_predicates(*volume.ultrasound, {}, 1.5, 0.1, 0);
  ASSERT_TRUE(test::has_value(one));
  ASSERT_TRUE(test::has_value(many));
  EXPECT_TRUE(std::ranges::equal(one->source->values(), many->source->values()));
}

TEST(PredicateShadingTest, RejectsWhatCannotBeShaded) {
  const auto volume = ball_volume();
  for (const double smoothing : {0.0, -1.0, 21.0, std::nan("")}) {
    EXPECT_TRUE(test::rejects(shading_of_predicates(*volume.ultrasound, {}, smoothing, 0.1, 1),
                              ErrorCode::kUsage, {"smoothing", "20 mm"}));
  }
  for (const double full : {0.0, 1e9, std::nan("")}) {
    EXPECT_TRUE(test::rejects(shading_of_predicates(*volume.ultrasound, {}, 1, full, 1),
                              ErrorCode::kUsage, {"full gradient"}));
  }
  Scene scene = shaded_scene(1);
  ASSERT_TRUE(test::has_value(validate(scene)));
  scene.predicates->shading->diffuse = std::nan("");
  EXPECT_TRUE(
      test::rejects(validate(scene), ErrorCode::kMalformedData, {"predicates.shading.diffuse"}));
  scene = shaded_scene(1);
  scene.predicates->shading->source =
      test::make_volume(test::centred_grid({5, 5, 5}, {1, 1, 1}), [](int, int, int) { return 0; });
  EXPECT_TRUE(
      test::rejects(validate(scene), ErrorCode::kMalformedData, {"shading.source", "another"}));
  scene.predicates->shading->source = nullptr;
  EXPECT_TRUE(
      test::rejects(validate(scene), ErrorCode::kMalformedData, {"shading.source", "none"}));
}

TEST(PredicateShadingTest, AnotherShadingIsAnotherImage) {
  const Scene scene = shaded_scene(1);
  Scene other = scene;
  EXPECT_EQ(change_between(scene, other), SceneChange::kNothing);
  other.predicates->shading->specular = 0;
  EXPECT_NE(change_between(scene, other), SceneChange::kNothing);
  other.predicates->shading.reset();
  EXPECT_NE(change_between(scene, other), SceneChange::kNothing);
}

TEST(PredicateShadingTest, CoarseImagesAreShadedToo) {
  const Scene scene = shaded_scene(1);
  const auto set = PredicateSet::create(*scene.predicates, scene.ct, position_of(scene));
  ASSERT_TRUE(test::has_value(set));
  CoarseVolumes volumes;
  const Scene coarse = volumes.of(scene, *set);
  ASSERT_TRUE(coarse.predicates->shading);
  EXPECT_TRUE(test::has_value(validate(coarse)));
  EXPECT_EQ(volumes.of(scene, *set).predicates->shading->source,
            coarse.predicates->shading->source);
}

}  // namespace
}  // namespace nav::render
