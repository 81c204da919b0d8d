// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/scene.hpp"

#include <limits>

#include "render/engine.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

Scene full_scene() {
  const auto ct =
      test::make_volume(test::centred_grid({4, 4, 4}, {1, 1, 1}), [](int, int, int) { return 0; });
  Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(100, 20, false));
  scene.plane = test::upright_plane(test::grey_picture(8, 6, 100), 1, {0, 0, 3});
  scene.plane->frame.outline = SectorOutline{{0, -10}, 11, 20, 0.5};
  scene.needle = test::needle({0, 0, 0}, {0, 0, 50});
  scene.spheres.push_back({{{0, 0, 0}}, 3});
  return scene;
}

TEST(ValidateSceneTest, AcceptsAFullScene) { EXPECT_TRUE(test::has_value(validate(full_scene()))); }

TEST(ValidateSceneTest, NamesTheField) {
  const auto expect_refused = [](auto change, const std::string& field) {
    Scene scene = full_scene();
    change(scene);
    EXPECT_TRUE(test::refuses(validate(scene), ErrorCode::kMalformedData, {field})) << field;
    // Every engine asks validate() first.
    EXPECT_FALSE(make_cpu_engine()->render(scene).has_value()) << field;
    EXPECT_FALSE(make_reference_engine()->render(scene).has_value()) << field;
  };
  expect_refused([](Scene& s) { s.ct = nullptr; }, "ct: expected a volume");
  expect_refused([](Scene& s) { s.width = 0; }, "width");
  expect_refused([](Scene& s) { s.height = 16385; }, "height");
  expect_refused([](Scene& s) { s.camera.eye_ct.mm.x() = kNan; }, "camera.eye_ct");
  expect_refused([](Scene& s) { s.camera.eye_ct.mm.x() = 1e300; }, "camera.eye_ct");
  expect_refused([](Scene& s) { s.camera.look_at_ct = s.camera.eye_ct; }, "camera.look_at_ct");
  expect_refused([](Scene& s) { s.camera.up_ct.v.setZero(); }, "camera.up_ct");
  expect_refused([](Scene& s) { s.camera.up_ct.v = {0, 5, 0}; }, "not parallel");
  expect_refused([](Scene& s) { s.camera.vertical_fov_rad = 0; }, "camera.vertical_fov_rad");
  expect_refused([](Scene& s) { s.camera.vertical_fov_rad = kNan; }, "camera.vertical_fov_rad");
  expect_refused(
      [](Scene& s) {
        s.camera.orthographic = true;
        s.camera.orthographic_height_mm = -1;
      },
      "camera.orthographic_height_mm");
  expect_refused([](Scene& s) { s.shading.diffuse = kNan; }, "shading.diffuse");
  expect_refused([](Scene& s) { s.shading.shininess = -1; }, "shading.shininess");
  expect_refused([](Scene& s) { s.quality.step_voxels = 0; }, "quality.step_voxels");
  expect_refused([](Scene& s) { s.quality.step_voxels = 17; }, "quality.step_voxels");
  expect_refused([](Scene& s) { s.quality.opaque_at = 0; }, "quality.opaque_at");
  expect_refused([](Scene& s) { s.background_rgb.y() = 2; }, "background_rgb");
  expect_refused([](Scene& s) { s.plane->frame.pixels = {}; }, "plane.frame.pixels");
  expect_refused([](Scene& s) { s.plane->frame.grid.mm_per_pixel.setZero(); }, "plane.frame");
  expect_refused([](Scene& s) { s.plane->opacity = 1.01; }, "plane.opacity");
  expect_refused([](Scene& s) { s.plane->frame.outline->radius_max_mm = 5; }, "radius_max_mm");
  expect_refused([](Scene& s) { s.plane->frame.outline->half_angle_rad = kNan; }, "half_angle_rad");
  expect_refused([](Scene& s) { s.needle->tip_ct.mm.z() = kNan; }, "needle.tip_ct");
  expect_refused([](Scene& s) { s.needle->hub_ct = s.needle->tip_ct; }, "needle.hub_ct");
  expect_refused([](Scene& s) { s.needle->radius_mm = 0; }, "needle.radius_mm");
  expect_refused([](Scene& s) { s.spheres[0].radius_mm = kNan; }, "spheres[0].radius_mm");
  expect_refused([](Scene& s) { s.spheres[0].rgb.x() = -1; }, "spheres[0].rgb");
}

TEST(ValidateSceneTest, DoesNotJudgeWhatIsLost) {
  Scene scene = full_scene();
  scene.plane->safety = {SafetyState::kLost, "no pose"};
  scene.plane->frame.pixels = {};
  scene.needle->safety = {SafetyState::kLost, "no pose"};
  scene.needle->tip_ct.mm.x() = kNan;
  EXPECT_TRUE(test::has_value(validate(scene)));
  EXPECT_TRUE(test::has_value(make_cpu_engine()->render(scene)));
}

TEST(To8BitTest, RoundsToNearestAndClamps) {
  const Image2d<RgbaF> picture(
      2, 1, {{0.0F, 0.49F / 255, 0.51F / 255, 1.0F}, {-1.0F, 2.0F, 254.4F / 255, 1.0F}});
  const auto bytes = to_8bit(picture);
  EXPECT_EQ(bytes.at(0, 0), (Rgba8{0, 0, 1, 255}));
  EXPECT_EQ(bytes.at(1, 0), (Rgba8{0, 255, 254, 255}));
}

}  // namespace
}  // namespace nav::render
