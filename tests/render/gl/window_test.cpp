// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/window/window.hpp"

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
#include "tests/render/gl/gl_pictures.hpp"
#include "tests/render/gl/gl_scenes.hpp"
#include "tests/render/predicates/two_volume_scenes.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

#define SONDE_REQUIRE_DISPLAY() \
  if (std::getenv("DISPLAY") == nullptr) GTEST_SKIP() << "no X display (run under xvfb-run)"

TEST(WindowTest, ShowsTheSameImageAsTheHeadlessEngine) {
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
  const auto window = capture_window(scene);
  ASSERT_TRUE(test::has_value(window));
  test::keep_picture("window", *window);
  // The window blends in 8 bits and rounds colour and background separately. The engine rounds
  // once.
  constexpr int kTwoRoundings = 1;
  const auto found = test::difference(*window, to_8bit(headless->pixels), kTwoRoundings);
  EXPECT_EQ(found.fraction_above, 0) << found.max;
}

TEST(WindowTest, OverlayTextChangesOnlyItsOwnPixels) {
  SONDE_REQUIRE_DISPLAY();
  const Scene scene = test::ball_scene(test::oblique_grid(), 320, 240);
  const auto silent = capture_window(scene);
  ASSERT_TRUE(test::has_value(silent));
  using Align = WindowWords::Align;
  const auto spoken = capture_window(
      scene, {{"CT NOT REGISTERED", {255, 180, 0, 255}, 0.99, 0.9, Align::kRight, 15},
              {"", {255, 255, 255, 255}, 0.5, 0.5, Align::kCentre, 15}});
  ASSERT_TRUE(test::has_value(spoken));
  test::keep_picture("window-words", *spoken);
  int changed = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      if (silent->at(x, y) == spoken->at(x, y)) continue;
      ++changed;
      EXPECT_TRUE(y > 200 && y < 232 && x > 120) << x << ", " << y;
    }
  }
  EXPECT_GT(changed, 500);
}

TEST(WindowTest, ShowsUltrasoundInACtLikeTheHeadlessEngine) {
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

TEST(WindowTest, DrawsTheSameImageAfterItsContextIsLost) {
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

TEST(WindowTest, RequestsScenesAndClosesByItself) {
  SONDE_REQUIRE_DISPLAY();
  const auto scene =
      std::make_shared<const Scene>(test::ball_scene(test::cube_grid(16, 1.0), 64, 48));
  int asked = 0;
  const SceneSource source = [&]() -> std::shared_ptr<const Scene> {
    return asked++ % 3 == 0 ? scene : nullptr;
  };
  EXPECT_TRUE(test::has_value(show_window(source, {.refresh_hz = 100, .close_after_s = 2})));
  EXPECT_GT(asked, 3);  // The first image waits for the compiler.
}

TEST(WindowTest, TheHeadlessEngineWorksWhileAWindowIsOpen) {
  SONDE_REQUIRE_DISPLAY();
  const auto scene =
      std::make_shared<const Scene>(test::ball_scene(test::cube_grid(16, 1.0), 64, 48));
  CollectingDiagnostics diagnostics;
  auto engine = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(engine));
  int rendered = 0;
  const SceneSource source = [&] {
    if ((*engine)->render(*scene)) ++rendered;
    return scene;
  };
  EXPECT_TRUE(test::has_value(show_window(source, {.refresh_hz = 50, .close_after_s = 0.5})));
  EXPECT_GT(rendered, 1);
}

TEST(WindowTest, AnInvalidSceneClosesTheWindowWithTheError) {
  SONDE_REQUIRE_DISPLAY();
  Scene bad = test::ball_scene(test::cube_grid(16, 1.0), 64, 48);
  const auto good = std::make_shared<const Scene>(bad);
  bad.quality.step_voxels = 1000;
  int asked = 0;
  const SceneSource source = [&] {
    return ++asked < 3 ? good : std::make_shared<const Scene>(bad);
  };
  EXPECT_FALSE(show_window(source, {.refresh_hz = 100, .close_after_s = 10}).has_value());
  EXPECT_EQ(asked, 3);
}

TEST(WindowTest, RejectsAnInvalidRefreshRate) {
  EXPECT_TRUE(test::refuses(
      show_window(test::ball_scene(test::cube_grid(4, 1.0)), WindowOptions{.refresh_hz = 0}),
      ErrorCode::kUsage, {"refresh_hz"}));
}

constexpr double kRoundingMm = 1e-9;

TEST(WindowCameraTest, OrbitKeepsTheDistanceAndTurnsTheEye) {
  const Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  const Eigen::Vector3d before = camera.eye_ct.mm - camera.look_at_ct.mm;
  const Camera yawed = orbited(camera, 0.3, 0);
  const Eigen::Vector3d after = yawed.eye_ct.mm - yawed.look_at_ct.mm;
  EXPECT_NEAR(after.norm(), before.norm(), kRoundingMm);
  EXPECT_NEAR(std::acos(after.normalized().dot(before.normalized())), 0.3, kRoundingMm);
  const Eigen::Vector3d right = (-before).cross(camera.up_ct.v);
  EXPECT_GT((yawed.eye_ct.mm - camera.eye_ct.mm).dot(right), 0);
  const Camera pitched = orbited(camera, 0, 0.3);
  EXPECT_GT((pitched.eye_ct.mm - camera.eye_ct.mm).dot(camera.up_ct.v), 0);
}

TEST(WindowCameraTest, OrbitPassesThePole) {
  Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  const Camera start = camera;
  for (int i = 0; i < 100; ++i) camera = orbited(camera, 0, 2 * M_PI / 100);
  EXPECT_LT((camera.eye_ct.mm - start.eye_ct.mm).norm(), kRoundingMm);
}

TEST(WindowCameraTest, PanMovesByFractionsOfTheImageHeight) {
  Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  camera.orthographic = true;
  const Camera moved = panned(camera, 0, 0.25);
  const Eigen::Vector3d shift = moved.look_at_ct.mm - camera.look_at_ct.mm;
  EXPECT_NEAR(shift.norm(), 0.25 * camera.orthographic_height_mm, kRoundingMm);
  EXPECT_LT((moved.eye_ct.mm - camera.eye_ct.mm - shift).norm(), kRoundingMm);
  EXPECT_NEAR(shift.dot(camera.look_at_ct.mm - camera.eye_ct.mm), 0, kRoundingMm);
}

TEST(WindowCameraTest, ZoomDividesDistanceAndHeight) {
  const Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  const Camera nearer = zoomed(camera, 2);
  EXPECT_NEAR((nearer.eye_ct.mm - nearer.look_at_ct.mm).norm(),
              0.5 * (camera.eye_ct.mm - camera.look_at_ct.mm).norm(), kRoundingMm);
  EXPECT_NEAR(nearer.orthographic_height_mm, 0.5 * camera.orthographic_height_mm, kRoundingMm);
}

bool is_seen_by(const Camera& camera) {
  Scene scene = test::ball_scene(test::cube_grid(16, 1.0));
  scene.camera = camera;
  return test::has_value(validate(scene));
}

TEST(WindowCameraTest, ZoomingNeverLosesTheCamera) {
  constexpr int kManyTurns = 2000;
  for (const bool orthographic : {false, true}) {
    Camera start = test::ball_scene(test::cube_grid(16, 1.0)).camera;
    start.orthographic = orthographic;
    for (const double factor : {1.1, 1 / 1.1}) {
      Camera camera = start;
      for (int i = 0; i < kManyTurns; ++i) camera = zoomed(camera, factor);
      EXPECT_TRUE(is_seen_by(camera)) << orthographic << ' ' << factor;
      // The return from the limit takes as many turns as the way from here to the limit.
      const auto size = [&](const Camera& c) {
        return orthographic ? c.orthographic_height_mm : (c.eye_ct.mm - c.look_at_ct.mm).norm();
      };
      int turns = 0;
      while (turns < kManyTurns && (size(camera) > size(start)) == (factor < 1)) {
        camera = zoomed(camera, 1 / factor);
        ++turns;
      }
      EXPECT_LT(turns, 150) << orthographic << ' ' << factor;
    }
  }
}

TEST(WindowCameraTest, DraggingNeverLosesTheCamera) {
  constexpr int kManyDrags = 1000;
  for (const bool orthographic : {false, true}) {
    Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
    camera.orthographic = orthographic;
    for (int i = 0; i < kManyDrags; ++i) camera = zoomed(camera, 0.5);
    for (int i = 0; i < kManyDrags; ++i) camera = panned(camera, 1, -1);
    EXPECT_TRUE(is_seen_by(camera)) << orthographic;
    for (int i = 0; i < kManyDrags; ++i) {
      camera = orbited(camera, 0.7, -0.4);
      camera = zoomed(camera, i % 2 == 0 ? 0.1 : 9.0);
    }
    EXPECT_TRUE(is_seen_by(camera)) << orthographic;
    const Camera back = panned(camera, -1, 1);
    EXPECT_TRUE(is_seen_by(back)) << orthographic;
  }
}

TEST(WindowCameraTest, AViewBeyondTheLimitsCanOnlyReturn) {
  Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  constexpr double kFarMm = 1e6;
  camera.eye_ct.mm = camera.look_at_ct.mm + Eigen::Vector3d(0, -kFarMm, 0);
  const auto distance_mm = [](const Camera& c) { return (c.eye_ct.mm - c.look_at_ct.mm).norm(); };
  EXPECT_NEAR(distance_mm(zoomed(camera, 0.5)), kFarMm, kFarMm * kRoundingMm);
  EXPECT_NEAR(distance_mm(zoomed(camera, 2)), kFarMm / 2, kFarMm * kRoundingMm);
}

}  // namespace
}  // namespace nav::render
