// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/camera_movement.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>

#include "tests/render/gl/gl_scenes.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

constexpr double kRoundingMm = 1e-9;

TEST(CameraMovementTest, OrbitKeepsTheDistanceAndTurnsTheEye) {
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

TEST(CameraMovementTest, OrbitPassesThePole) {
  Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  const Camera start = camera;
  for (int i = 0; i < 100; ++i) camera = orbited(camera, 0, 2 * M_PI / 100);
  EXPECT_LT((camera.eye_ct.mm - start.eye_ct.mm).norm(), kRoundingMm);
}

TEST(CameraMovementTest, PanMovesByFractionsOfTheImageHeight) {
  Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  camera.orthographic = true;
  const Camera moved = panned(camera, 0, 0.25);
  const Eigen::Vector3d shift = moved.look_at_ct.mm - camera.look_at_ct.mm;
  EXPECT_NEAR(shift.norm(), 0.25 * camera.orthographic_height_mm, kRoundingMm);
  EXPECT_LT((moved.eye_ct.mm - camera.eye_ct.mm - shift).norm(), kRoundingMm);
  EXPECT_NEAR(shift.dot(camera.look_at_ct.mm - camera.eye_ct.mm), 0, kRoundingMm);
}

TEST(CameraMovementTest, ZoomDividesDistanceAndHeight) {
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

TEST(CameraMovementTest, ZoomingNeverLosesTheCamera) {
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

TEST(CameraMovementTest, DraggingNeverLosesTheCamera) {
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

TEST(CameraMovementTest, InputMovesTheSceneWithTheMouse) {
  const Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  const auto same = [](const Camera& a, const Camera& b) {
    return (a.eye_ct.mm - b.eye_ct.mm).norm() + (a.look_at_ct.mm - b.look_at_ct.mm).norm() <
           kRoundingMm;
  };
  CameraMovement movement;
  EXPECT_TRUE(same(moved(camera, movement), camera));
  movement.orbit = {0.1, 0.2};
  EXPECT_TRUE(same(moved(camera, movement), orbited(camera, -0.1 * M_PI, -0.2 * M_PI)));
  movement = {};
  movement.pan = {0.1, 0.2};
  EXPECT_TRUE(same(moved(camera, movement), panned(camera, -0.1, -0.2)));
  movement = {};
  movement.zoom = 2;
  EXPECT_TRUE(same(moved(camera, movement), zoomed(camera, 2)));
}

TEST(CameraMovementTest, AViewBeyondTheLimitsCanOnlyReturn) {
  Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  constexpr double kFarMm = 1e6;
  camera.eye_ct.mm = camera.look_at_ct.mm + Eigen::Vector3d(0, -kFarMm, 0);
  const auto distance_mm = [](const Camera& c) { return (c.eye_ct.mm - c.look_at_ct.mm).norm(); };
  EXPECT_NEAR(distance_mm(zoomed(camera, 0.5)), kFarMm, kFarMm * kRoundingMm);
  EXPECT_NEAR(distance_mm(zoomed(camera, 2)), kFarMm / 2, kFarMm * kRoundingMm);
}

TEST(CameraMovementTest, LooksAtAPointFromTheSameSideAndDistance) {
  const Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  const Point<frames::Ct> there{{3, -2, 5}};
  const Camera looking = looking_at(camera, there);
  EXPECT_EQ(looking.look_at_ct.mm, there.mm);
  const Eigen::Vector3d before = camera.eye_ct.mm - camera.look_at_ct.mm;
  EXPECT_LT((looking.eye_ct.mm - looking.look_at_ct.mm - before).norm(), kRoundingMm);
  const Camera nowhere = looking_at(camera, {{1e300, 0, 0}});
  EXPECT_EQ(nowhere.look_at_ct.mm, camera.look_at_ct.mm) << "no scene allows it";
}

TEST(CameraMovementTest, EachSideOfThePatientHasItsRight) {
  const Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  const double distance_mm = (camera.eye_ct.mm - camera.look_at_ct.mm).norm();
  // The direction to the right in the image, LPS.
  const std::vector<std::pair<ViewFrom, Eigen::Vector3d>> sides{
      {ViewFrom::kAnterior, {1, 0, 0}}, {ViewFrom::kPosterior, {-1, 0, 0}},
      {ViewFrom::kLeft, {0, 1, 0}},     {ViewFrom::kRight, {0, -1, 0}},
      {ViewFrom::kHead, {-1, 0, 0}},    {ViewFrom::kFeet, {1, 0, 0}}};
  for (const auto& [side, right] : sides) {
    const Camera seen = seen_from(camera, side);
    const Eigen::Vector3d forward = (seen.look_at_ct.mm - seen.eye_ct.mm).normalized();
    EXPECT_LT((forward.cross(seen.up_ct.v).normalized() - right).norm(), kRoundingMm)
        << static_cast<int>(side);
    EXPECT_NEAR((seen.eye_ct.mm - seen.look_at_ct.mm).norm(), distance_mm, kRoundingMm);
  }
}

}  // namespace
}  // namespace nav::render
