// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <gtest/gtest.h>
#include <random>
#include <vtkOpenGLRenderWindow.h>
#include <vtkRenderer.h>

#include "render/gl_volume_prop.hpp"
#include "render/vtk_offscreen.hpp"
#include "tests/render/gl/gl_pictures.hpp"
#include "tests/render/gl/gl_random_scenes.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

/// Another picture of the same size.
Image2d<std::uint8_t> noise_like(const Image2d<std::uint8_t>& picture, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> pixels(picture.pixels().size());
  for (std::uint8_t& value : pixels) value = static_cast<std::uint8_t>(random());
  return {picture.width(), picture.height(), std::move(pixels)};
}

class GlLiveTest : public testing::Test {
 protected:
  void SetUp() override {
    auto window = OffscreenWindow::create(96, 72);
    ASSERT_TRUE(test::has_value(window));
    window_ = std::move(window).value();
    view_ = std::make_unique<SceneView>(window_->window());
  }
  std::vector<RgbaF> draw(const Scene& scene) {
    EXPECT_TRUE(test::has_value(view_->draw(std::make_shared<const Scene>(scene))));
    return view_->raycaster().read();
  }
  /// Without anything kept from before.
  std::vector<RgbaF> draw_anew(const Scene& scene) {
    SceneView fresh(window_->window());
    view_->renderer().DrawOff();
    EXPECT_TRUE(test::has_value(fresh.draw(std::make_shared<const Scene>(scene))));
    view_->renderer().DrawOn();
    return fresh.raycaster().read();
  }
  [[nodiscard]] RenderStatistics statistics() const { return view_->raycaster().statistics(); }

  std::unique_ptr<OffscreenWindow> window_;
  std::unique_ptr<SceneView> view_;
};

bool same_bits(const std::vector<RgbaF>& a, const std::vector<RgbaF>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(RgbaF)) == 0;
}

TEST_F(GlLiveTest, ANewPictureTakesNoSampleAndIsWhatAFullDrawingWouldBe) {
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
      EXPECT_FALSE(same_bits(live, before));
      EXPECT_TRUE(same_bits(live, draw_anew(scene))) << opacity << cut;
    }
  }
}

TEST_F(GlLiveTest, NothingIsDrawnWhenNothingChanged) {
  Scene scene = test::ball_scene(test::cube_grid(32, 1.0));
  scene.plane = test::test_plane(scene.ct->grid(), SafetyState::kValid);
  const auto before = draw(scene);
  const GlUploads sent = view_->raycaster().uploads();
  scene.background_rgb.setConstant(0.7);  // Not the ray caster's.
  const auto after = draw(scene);
  EXPECT_EQ(statistics().volume_samples, 0U);
  EXPECT_EQ(view_->raycaster().uploads().pictures, sent.pictures);
  EXPECT_TRUE(same_bits(before, after));
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

TEST_F(GlLiveTest, ThePictureIsInterpolatedFinely) {
  Scene scene = test::ball_scene(test::cube_grid(16, 1.0));
  scene.transfer =
      *TransferFunction::create("clear", {{0, {1, 1, 1}, 0.0, 0}, {1, {1, 1, 1}, 0.0, 0}});
  scene.plane = test::test_plane(scene.ct->grid(), SafetyState::kValid);
  scene.plane->frame.pixels = noise_like(scene.plane->frame.pixels, 3);
  const auto expected = make_reference_engine()->render(scene);
  ASSERT_TRUE(test::has_value(expected));
  const auto found = draw(scene);
  // 256 levels between two pixels of noise would miss by up to 2e-3.
  constexpr float kRounding = 1e-4F;
  int seen = 0;
  float worst = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    // Grey and fully inside: the border is coloured, and where it begins is a matter of rounding.
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
