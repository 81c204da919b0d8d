// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <gtest/gtest.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include "render/engine.hpp"
#include "render/gl/gl_volume_prop.hpp"
#include "render/vtk/vtk_convert.hpp"
#include "tests/render/gl/gl_images.hpp"
#include "tests/render/gl/gl_scenes.hpp"
#include "tests/render/predicates/two_volume_scenes.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

#define SONDE_REQUIRE_DISPLAY() \
  if (std::getenv("DISPLAY") == nullptr) GTEST_SKIP() << "no X display (run under xvfb-run)"

TEST(SceneInAWindowTest, IsTheSameImageAsOfTheHeadlessEngine) {
  SONDE_REQUIRE_DISPLAY();
  Scene scene = test::ball_scene(test::oblique_grid(), 160, 120);
  scene.plane = test::test_plane(scene.ct->grid(), SafetyState::kValid);
  scene.needle = test::test_needle(scene.ct->grid(), SafetyState::kValid);
  scene.spheres = test::test_spheres(scene.ct->grid());
  CollectingDiagnostics diagnostics;
  auto engine = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(engine));
  const auto headless = (*engine)->render(scene);
  ASSERT_TRUE(test::has_value(headless));
  vtkNew<vtkRenderWindow> window;
  window->SetMultiSamples(0);
  window->SetSize(scene.width, scene.height);
  SceneView view(*window);
  ASSERT_TRUE(test::has_value(view.draw(std::make_shared<const Scene>(scene))));
  const Image2d<Rgba8> shown = read_pixels(*window);
  test::keep_image("window", shown);
  // The window blends in 8 bits and rounds colour and background separately. The engine rounds
  // once.
  constexpr int kTwoRoundings = 1;
  const auto found = test::difference(shown, to_8bit(headless->pixels), kTwoRoundings);
  EXPECT_EQ(found.fraction_above, 0) << found.max;
}

TEST(SceneInAWindowTest, ShowsUltrasoundInACtLikeTheHeadlessEngine) {
  SONDE_REQUIRE_DISPLAY();
  VoxelGrid where = test::centred_grid({15, 15, 15}, {1, 0.8, 0.9});
  where.origin_mm.y() += 9;
  Scene scene = test::fog_scene(where, 0.05);
  scene.width = 64;
  scene.height = 48;
  vtkNew<vtkRenderWindow> window;
  window->SetMultiSamples(0);
  window->SetSize(scene.width, scene.height);
  SceneView view(*window);
  CollectingDiagnostics diagnostics;
  auto engine = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(engine));
  Image2d<Rgba8> last;
  for (const double importance : {1.0, 0.5, 0.0}) {
    scene.ultrasound->ct_importance = importance;
    ASSERT_TRUE(test::has_value(view.draw(std::make_shared<const Scene>(scene))));
    const Image2d<Rgba8> shown = read_pixels(*window);
    const auto headless = (*engine)->render(scene);
    ASSERT_TRUE(test::has_value(headless));
    EXPECT_EQ(test::difference(shown, to_8bit(headless->pixels), 1).fraction_above, 0);
    if (!last.empty()) {
      EXPECT_GT(test::difference(shown, last, 1).fraction_above, 0.05) << importance;
    }
    last = shown;
  }
  EXPECT_EQ(view.raycaster().compiled(), 1);
}

TEST(SceneInAWindowTest, IsTheSameImageAfterItsContextIsLost) {
  SONDE_REQUIRE_DISPLAY();
  auto scene = std::make_shared<Scene>(test::ball_scene(test::cube_grid(24, 1.0), 96, 64));
  scene->plane = test::test_plane(scene->ct->grid(), SafetyState::kValid);
  vtkNew<vtkRenderWindow> window;
  window->SetMultiSamples(0);
  window->SetSize(scene->width, scene->height);
  SceneView view(*window);
  ASSERT_TRUE(test::has_value(view.draw(scene)));
  const Image2d<Rgba8> before = read_pixels(*window);
  // The context of the window ends here, with all its textures and programs.
  window->Finalize();
  ASSERT_TRUE(test::has_value(view.draw(scene)));
  const Image2d<Rgba8> after = read_pixels(*window);
  ASSERT_EQ(after.pixels().size(), before.pixels().size());
  EXPECT_EQ(
      std::memcmp(after.pixels().data(), before.pixels().data(), before.pixels().size_bytes()), 0);
  const auto background = after.pixels().front();
  EXPECT_TRUE(std::any_of(after.pixels().begin(), after.pixels().end(),
                          [&](const Rgba8& p) { return p.r != background.r; }));
}

}  // namespace
}  // namespace nav::render
