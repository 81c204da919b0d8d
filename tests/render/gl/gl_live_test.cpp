// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <functional>
#include <gtest/gtest.h>
#include <random>

#include "tests/render/gl/gl_random_scenes.hpp"
#include "tests/render/gl/gl_scenes.hpp"
#include "tests/render/gl/gl_view.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

/// Another image of the same size.
Image2d<std::uint8_t> noise_like(const Image2d<std::uint8_t>& image, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> pixels(image.pixels().size());
  for (std::uint8_t& value : pixels) value = static_cast<std::uint8_t>(random());
  return {image.width(), image.height(), std::move(pixels)};
}

class GlLiveTest : public test::GlViewTest {};

TEST_F(GlLiveTest, EditsGiveTheSameImageAsAFullRendering) {
  constexpr unsigned kSeeds = 4;
  constexpr int kEdits = 15;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    test::RandomScenes scenes(seed);
    Scene scene = scenes.next();
    for (int edit = 0; edit < kEdits; ++edit) {
      scenes.edit(scene);
      const auto kept = draw(scene);
      EXPECT_TRUE(test::same_bits(kept, draw_anew(scene))) << "seed " << seed << ", edit " << edit;
    }
  }
}

TEST_F(GlLiveTest, ALostPlaneFreesSpaceForMoreRays) {
  Scene scene = test::ball_scene(test::cube_grid(48, 2), 320, 240);
  scene.quality.pixel_error = 1e-3;
  const Camera near = scene.camera;
  scene.camera.eye_ct.mm *= 4;  // Few rays meet anything visible.
  scene.plane = test::test_plane(scene.ct->grid(), SafetyState::kValid);
  draw(scene);
  scene.plane->safety = {SafetyState::kLost, "lost"};
  scene.camera = near;
  const auto kept = draw(scene);
  EXPECT_TRUE(test::same_bits(kept, draw_anew(scene)));
}

TEST_F(GlLiveTest, ANewUltrasoundImageTakesNoSample) {
  for (const double opacity : {1.0, 0.6}) {
    for (const bool cut : {false, true}) {
      Scene scene = test::ball_scene(test::oblique_grid());
      scene.plane = test::test_plane(scene.ct->grid(), SafetyState::kValid);
      scene.plane->opacity = opacity;
      scene.spheres = test::test_spheres(scene.ct->grid());
      if (cut) scene.cutaway.emplace();
      const auto before = draw(scene);
      EXPECT_GT(statistics().volume_samples, 0U);
      scene.plane->frame.pixels = noise_like(scene.plane->frame.pixels, 7);
      scene.plane->frame.sequence += 1;
      const auto live = draw(scene);
      EXPECT_EQ(statistics().volume_samples, 0U);
      EXPECT_EQ(statistics().gradient_samples, 0U);
      EXPECT_FALSE(test::same_bits(live, before));
      EXPECT_TRUE(test::same_bits(live, draw_anew(scene))) << opacity << cut;
    }
  }
}

TEST_F(GlLiveTest, AnUnchangedSceneIsNotDrawnAgain) {
  Scene scene = test::ball_scene(test::cube_grid(32, 1.0));
  scene.plane = test::test_plane(scene.ct->grid(), SafetyState::kValid);
  const auto before = draw(scene);
  const GlUploads sent = caster().uploads();
  scene.background_rgb.setConstant(0.7);  // The background does not concern the ray caster.
  const auto after = draw(scene);
  EXPECT_EQ(statistics().volume_samples, 0U);
  EXPECT_EQ(caster().uploads().images, sent.images);
  EXPECT_TRUE(test::same_bits(before, after));
}

TEST_F(GlLiveTest, EveryOtherChangeCastsRaysAgain) {
  Scene scene = test::ball_scene(test::cube_grid(24, 1.0));
  scene.plane = test::test_plane(scene.ct->grid(), SafetyState::kValid);
  scene.cutaway.emplace();
  (void)draw(scene);
  const auto changes = std::vector<std::function<void(Scene&)>>{
      [](Scene& s) { s.camera.eye_ct.mm.x() += 1; },
      [](Scene& s) { s.plane->opacity = 0.4; },
      [](Scene& s) {
        s.plane->ct_from_image = {
            s.plane->ct_from_image.rotation(),
            s.plane->ct_from_image.translation_mm() + Eigen::Vector3d(1, 0, 0)};
      },
      [](Scene& s) { s.plane->safety.state = SafetyState::kDegraded; },
      [](Scene& s) { s.transfer = *preset_transfer_function("ct-bone"); },
      [](Scene& s) { s.shading.ambient = 0.2; },
      [](Scene& s) { s.quality.step_voxels = 1; },
      [](Scene& s) { s.cutaway->overlay_mm = 3; },
      [](Scene& s) {
        s.cutaway->polygons.push_back({{{{0, 0, 0}}, {{5, 0, 0}}, {{0, 5, 0}}}});
      },
      [](Scene& s) { s.needle = test::test_needle(s.ct->grid(), SafetyState::kValid); },
      [](Scene& s) {
        s.lines.push_back({{{0, 0, 0}}, {{9, 9, 9}}});
      },
      [](Scene& s) { s.ct = test::ball_phantom(test::cube_grid(25, 1.0)); }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    changes[i](scene);
    (void)draw(scene);
    EXPECT_GT(statistics().volume_samples, 0U) << i;
  }
}

/// A plane in a small cutaway that does not affect most rays.
Scene small_cutaway() {
  Scene scene = test::ball_scene(test::oblique_grid());
  scene.plane = test::test_plane(scene.ct->grid(), SafetyState::kValid);
  scene.plane->opacity = 0.7;
  scene.plane->frame.grid.mm_per_pixel *= 0.4;
  scene.plane->frame.grid.origin_mm *= 0.4;
  scene.spheres = test::test_spheres(scene.ct->grid());
  scene.cutaway.emplace();
  scene.cutaway->theta1_rad = 0.2;
  scene.cutaway->theta2_rad = 0.3;
  scene.cutaway->overlay_mm = 4;
  return scene;
}

TEST_F(GlLiveTest, AMovedPlaneCastsOnlyTheRaysItCanAffect) {
  const std::vector<std::function<void(Scene&)>> appearances{
      [](Scene&) {},
      [](Scene& s) { s.camera.orthographic = true; },
      [](Scene& s) { s.quality.jitter = true; },
      [](Scene& s) { s.plane->opacity = 1; },
      [](Scene& s) { s.projection = Projection::kMaximum; },
      [](Scene& s) { s.cutaway->meshes = {test::ball_mesh(s.ct->grid().centre().mm, 3)}; }};
  std::mt19937 random(3);
  std::normal_distribution<double> jitter(0, 0.4);
  for (std::size_t appearance = 0; appearance < appearances.size(); ++appearance) {
    Scene scene = small_cutaway();
    appearances[appearance](scene);
    (void)draw(scene);
    const RenderStatistics all = statistics();
    ASSERT_EQ(all.rays, 96U * 72U);
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d shift(jitter(random), jitter(random), jitter(random));
      scene.plane->ct_from_image = {scene.plane->ct_from_image.rotation(),
                                    scene.plane->ct_from_image.translation_mm() + shift};
      // A new image may arrive with the new position.
      if (i == 2) scene.plane->frame.pixels = noise_like(scene.plane->frame.pixels, 5);
      const auto moved = draw(scene);
      const RenderStatistics cast = statistics();
      EXPECT_GT(cast.rays, 0U) << appearance;
      EXPECT_LT(cast.rays, all.rays / 2) << appearance;
      EXPECT_LT(cast.volume_samples, all.volume_samples / 2) << appearance;
      EXPECT_TRUE(test::same_bits(moved, draw_anew(scene))) << appearance << " " << i;
    }
  }
}

TEST_F(GlLiveTest, EveryEditCastsOnlyTheRaysItConcerns) {
  Scene scene = small_cutaway();
  scene.needle = test::test_needle(scene.ct->grid(), SafetyState::kValid);
  scene.lines = {{scene.needle->tip_ct, scene.ct->grid().centre()}};
  (void)draw(scene);
  const std::vector<std::function<void(Scene&)>> edits{
      [](Scene& s) { s.needle->tip_ct.mm.x() += 1; },
      [](Scene& s) { s.needle->safety.state = SafetyState::kStale; },
      [](Scene& s) { s.spheres[1].rgb.x() = 0.9; },
      [](Scene& s) { s.spheres[0].opacity = 0.9; },
      [](Scene& s) { s.spheres.pop_back(); },
      [](Scene& s) { s.lines[0].radius_mm = 1; },
      [](Scene& s) { s.plane->safety.state = SafetyState::kDegraded; },
      [](Scene& s) { s.plane->opacity = 0.3; },
      [](Scene& s) {
        s.plane->frame.outline = SectorOutline{{0, -5}, 6, 25, 0.5};
      },
      [](Scene& s) { s.cutaway->around_needle = true; },
      [](Scene& s) { s.cutaway->overlay_mm = 9; },
      [](Scene& s) { s.cutaway->theta2_rad = 0.5; },
      [](Scene& s) { s.cutaway->around_plane = false; }};
  for (std::size_t i = 0; i < edits.size(); ++i) {
    edits[i](scene);
    const auto after = draw(scene);
    EXPECT_GT(statistics().rays, 0U) << i;
    EXPECT_LT(statistics().rays, 96U * 72U) << i;
    EXPECT_TRUE(test::same_bits(after, draw_anew(scene))) << i;
  }
}

TEST_F(GlLiveTest, CutawayCountsAgreeWithTheCpuEngine) {
  const Scene scene = small_cutaway();
  (void)draw(scene);
  const RenderStatistics found = statistics();
  const auto expected = make_cpu_engine()->render(scene);
  ASSERT_TRUE(test::has_value(expected));
  const auto close = [](std::uint64_t a, std::uint64_t b, double share) {
    return std::abs(static_cast<double>(a) - static_cast<double>(b)) <=
           share * static_cast<double>(b);
  };
  EXPECT_GT(found.cutaway_rays, 0U);
  EXPECT_TRUE(close(found.cutaway_rays, expected->statistics.cutaway_rays, 0.01))
      << found.cutaway_rays << " " << expected->statistics.cutaway_rays;
  // The CPU engine does not count cells that it finds to be empty only after sampling them.
  EXPECT_GE(found.faded_cells, expected->statistics.faded_cells);
  EXPECT_TRUE(close(found.faded_cells, expected->statistics.faded_cells, 1))
      << found.faded_cells << " " << expected->statistics.faded_cells;
  Scene whole = scene;
  whole.cutaway.reset();
  (void)draw(whole);
  EXPECT_EQ(statistics().cutaway_rays, 0U);
  EXPECT_EQ(statistics().faded_cells, 0U);
}

TEST_F(GlLiveTest, InterpolatesTheUltrasoundImageFinely) {
  Scene scene = test::ball_scene(test::cube_grid(16, 1.0));
  scene.transfer =
      *TransferFunction::create("clear", {{0, {1, 1, 1}, 0.0, 0}, {1, {1, 1, 1}, 0.0, 0}});
  scene.plane = test::test_plane(scene.ct->grid(), SafetyState::kValid);
  scene.plane->frame.pixels = noise_like(scene.plane->frame.pixels, 3);
  const auto expected = make_reference_engine()->render(scene);
  ASSERT_TRUE(test::has_value(expected));
  const auto found = draw(scene);
  // With 256 levels between two pixels of noise, the error would be up to 2e-3.
  constexpr float kRounding = 1e-4F;
  int seen = 0;
  float worst = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    // Only grey pixels that are fully inside. The border is coloured, and its exact start depends
    // on rounding.
    const RgbaF& truth = expected->pixels.pixels()[i];
    if (found[i].a < 1 || found[i].r != found[i].g || truth.r != truth.g) continue;
    worst = std::max(worst, std::abs(found[i].r - truth.r));
    ++seen;
  }
  EXPECT_GT(seen, 1000);
  EXPECT_LE(worst, kRounding);
}

}  // namespace
}  // namespace nav::render
