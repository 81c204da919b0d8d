// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/scene.hpp"

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "render/engine.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

Scene full_scene() {
  const auto ct =
      test::make_volume(test::centred_grid({4, 4, 4}, {1, 1, 1}), [](int, int, int) { return 0; });
  Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(100, 20, false));
  scene.plane = test::upright_plane(test::grey_image(8, 6, 100), 1, {0, 0, 3});
  scene.plane->frame.outline = SectorOutline{{0, -10}, 11, 20, 0.5};
  scene.needle = test::needle({0, 0, 0}, {0, 0, 50});
  scene.spheres.push_back({{{0, 0, 0}}, 3});
  scene.lines.push_back({{{0, 0, 0}}, {{1, 2, 3}}});
  scene.cutaway.emplace();
  scene.cutaway->polygons.push_back({{{{0, 0, 0}}, {{1, 0, 0}}, {{1, 1, 0}}, {{0, 1, 0}}}});
  scene.cutaway->boxes.push_back({{{0, 0, 0}}, Eigen::Vector3d(1, 2, 3).asDiagonal()});
  scene.cutaway->meshes.push_back(std::make_shared<const MeshObject>(
      MeshObject{{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 1}}}, {{0, 1, 2}}}));
  return scene;
}

/// The mesh of full_scene() after a change.
template <class Change>
std::shared_ptr<const MeshObject> mesh_with(Change change) {
  MeshObject mesh = *full_scene().cutaway->meshes[0];
  change(mesh);
  return std::make_shared<const MeshObject>(std::move(mesh));
}

TEST(ValidateSceneTest, AcceptsAFullScene) { EXPECT_TRUE(test::has_value(validate(full_scene()))); }

TEST(ValidateSceneTest, NamesTheWrongField) {
  const auto expect_rejected = [](auto change, const std::string& field) {
    Scene scene = full_scene();
    change(scene);
    EXPECT_TRUE(test::rejects(validate(scene), ErrorCode::kMalformedData, {field})) << field;
    // Each engine calls validate() first.
    EXPECT_FALSE(make_cpu_engine()->render(scene).has_value()) << field;
    EXPECT_FALSE(make_reference_engine()->render(scene).has_value()) << field;
  };
  expect_rejected([](Scene& s) { s.ct = nullptr; }, "ct: expected a volume");
  expect_rejected([](Scene& s) { s.width = 0; }, "width");
  expect_rejected([](Scene& s) { s.height = 16385; }, "height");
  expect_rejected([](Scene& s) { s.camera.eye_ct.mm.x() = kNan; }, "camera.eye_ct");
  expect_rejected([](Scene& s) { s.camera.eye_ct.mm.x() = 1e300; }, "camera.eye_ct");
  expect_rejected([](Scene& s) { s.camera.look_at_ct = s.camera.eye_ct; }, "camera.look_at_ct");
  expect_rejected([](Scene& s) { s.camera.up_ct.v.setZero(); }, "camera.up_ct");
  expect_rejected([](Scene& s) { s.camera.up_ct.v = {0, 5, 0}; }, "not parallel");
  expect_rejected([](Scene& s) { s.camera.vertical_fov_rad = 0; }, "camera.vertical_fov_rad");
  expect_rejected([](Scene& s) { s.camera.vertical_fov_rad = kNan; }, "camera.vertical_fov_rad");
  expect_rejected(
      [](Scene& s) {
        s.camera.orthographic = true;
        s.camera.orthographic_height_mm = -1;
      },
      "camera.orthographic_height_mm");
  expect_rejected([](Scene& s) { s.shading.diffuse = kNan; }, "shading.diffuse");
  expect_rejected([](Scene& s) { s.shading.shininess = -1; }, "shading.shininess");
  expect_rejected([](Scene& s) { s.quality.step_voxels = 0; }, "quality.step_voxels");
  expect_rejected([](Scene& s) { s.quality.step_voxels = 17; }, "quality.step_voxels");
  expect_rejected([](Scene& s) { s.quality.opaque_at = 0; }, "quality.opaque_at");
  expect_rejected([](Scene& s) { s.background_rgb.y() = 2; }, "background_rgb");
  expect_rejected([](Scene& s) { s.plane->frame.pixels = {}; }, "plane.frame.pixels");
  expect_rejected([](Scene& s) { s.plane->frame.grid.mm_per_pixel.setZero(); }, "plane.frame");
  expect_rejected([](Scene& s) { s.plane->opacity = 1.01; }, "plane.opacity");
  expect_rejected([](Scene& s) { s.plane->frame.outline->radius_max_mm = 5; }, "radius_max_mm");
  expect_rejected([](Scene& s) { s.plane->frame.outline->half_angle_rad = kNan; },
                  "half_angle_rad");
  expect_rejected([](Scene& s) { s.plane->frame.outline->half_angle_rad = 1.6; }, "half_angle_rad");
  expect_rejected([](Scene& s) { s.needle->tip_ct.mm.z() = kNan; }, "needle.tip_ct");
  expect_rejected([](Scene& s) { s.needle->hub_ct = s.needle->tip_ct; }, "needle.hub_ct");
  expect_rejected([](Scene& s) { s.needle->radius_mm = 0; }, "needle.radius_mm");
  expect_rejected([](Scene& s) { s.spheres[0].radius_mm = kNan; }, "spheres[0].radius_mm");
  expect_rejected([](Scene& s) { s.spheres[0].rgb.x() = -1; }, "spheres[0].rgb");
  expect_rejected([](Scene& s) { s.lines[0].to_ct.mm.x() = kNan; }, "lines[0].to_ct");
  expect_rejected([](Scene& s) { s.spheres[0].opacity = 1.01; }, "spheres[0].opacity");
  expect_rejected([](Scene& s) { s.lines[0].opacity = 0; }, "lines[0].opacity");
  expect_rejected([](Scene& s) { s.quality.pixel_error = 1.01; }, "quality.pixel_error");
  expect_rejected([](Scene& s) { s.shading.emphasis = 1.1; }, "shading.emphasis");
  expect_rejected([](Scene& s) { s.shading.silhouette = kNan; }, "shading.silhouette");
  expect_rejected([](Scene& s) { s.shading.full_gradient_per_mm = 0; }, "full_gradient_per_mm");
  expect_rejected([](Scene& s) { s.grey.width_hu = 0; }, "grey.width_hu");
  expect_rejected([](Scene& s) { s.grey.level_hu = kNan; }, "grey.level_hu");
}

TEST(ValidateSceneTest, NamesTheWrongFieldOfTheCutaway) {
  const auto expect_rejected = [](auto change, const std::string& field) {
    Scene scene = full_scene();
    change(*scene.cutaway);
    EXPECT_TRUE(test::rejects(validate(scene), ErrorCode::kMalformedData, {field})) << field;
  };
  expect_rejected([](Cutaway& c) { c.theta1_rad = 0.9; }, "cutaway.theta1_rad: expected at most");
  expect_rejected([](Cutaway& c) { c.theta1_rad = 0; }, "cutaway.theta1_rad");
  expect_rejected([](Cutaway& c) { c.theta1_rad = kNan; }, "cutaway.theta1_rad");
  expect_rejected([](Cutaway& c) { c.theta2_rad = kNan; }, "cutaway.theta2_rad");
  expect_rejected([](Cutaway& c) { c.theta2_rad = 2; }, "cutaway.theta2_rad");
  expect_rejected([](Cutaway& c) { c.theta1_rad = c.theta2_rad = M_PI / 2; }, "below pi/2");
  expect_rejected([](Cutaway& c) { c.overlay_mm = -1e-9; }, "cutaway.overlay_mm");
  expect_rejected([](Cutaway& c) { c.overlay_mm = kNan; }, "cutaway.overlay_mm");
  expect_rejected([](Cutaway& c) { c.polygons[0].vertices_ct.resize(1); }, "2 to 256 vertices");
  expect_rejected([](Cutaway& c) { c.polygons[0].vertices_ct.resize(257); }, "2 to 256 vertices");
  expect_rejected([](Cutaway& c) { c.polygons[0].vertices_ct[2].mm.y() = kNan; }, "vertices_ct[2]");
  expect_rejected([](Cutaway& c) { c.polygons[0].vertices_ct[2].mm.z() = 0.1; }, "in one plane");
  expect_rejected([](Cutaway& c) { c.boxes[0].half_edges_ct(0, 0) = 0; }, "boxes[0].half_edges_ct");
  expect_rejected([](Cutaway& c) { c.boxes[0].half_edges_ct(0, 1) = 0.1; }, "right angles");
  expect_rejected([](Cutaway& c) { c.boxes[0].half_edges_ct(0, 1) = -0.1; }, "right angles");
  expect_rejected([](Cutaway& c) { c.boxes[0].half_edges_ct(0, 1) = kNan; }, "half_edges_ct");
  expect_rejected([](Cutaway& c) { c.meshes[0] = nullptr; }, "meshes[0]: expected at least one");
  const auto triangle = [](int index) {
    return [index](Cutaway& c) {
      c.meshes[0] = mesh_with([&](MeshObject& m) { m.triangles[0][1] = index; });
    };
  };
  expect_rejected(triangle(3), "meshes[0].triangles: expected indices of 3 vertices, found 3");
  expect_rejected(triangle(-1), "meshes[0].triangles");
  expect_rejected(
      [](Cutaway& c) {
        c.meshes[0] = mesh_with([](MeshObject& m) { m.vertices_ct[0].mm.z() = kNan; });
      },
      "meshes[0].vertices_ct");
}

TEST(ValidateSceneTest, RejectsEachNumberThatIsNan) {
  struct Number {
    std::function<double&(Scene&)> in;
    std::string field;
  };
  const std::vector<Number> numbers{
      {[](Scene& s) -> double& { return s.camera.eye_ct.mm.y(); }, "camera.eye_ct"},
      {[](Scene& s) -> double& { return s.camera.look_at_ct.mm.z(); }, "camera.look_at_ct"},
      {[](Scene& s) -> double& { return s.camera.up_ct.v.x(); }, "camera.up_ct"},
      {[](Scene& s) -> double& { return s.camera.vertical_fov_rad; }, "camera.vertical_fov_rad"},
      {[](Scene& s) -> double& { return s.shading.emphasis; }, "shading.emphasis"},
      {[](Scene& s) -> double& { return s.shading.full_gradient_per_mm; }, "full_gradient_per_mm"},
      {[](Scene& s) -> double& { return s.shading.ambient; }, "shading.ambient"},
      {[](Scene& s) -> double& { return s.shading.diffuse; }, "shading.diffuse"},
      {[](Scene& s) -> double& { return s.shading.specular; }, "shading.specular"},
      {[](Scene& s) -> double& { return s.shading.shininess; }, "shading.shininess"},
      {[](Scene& s) -> double& { return s.shading.cool_share; }, "shading.cool_share"},
      {[](Scene& s) -> double& { return s.shading.warm_share; }, "shading.warm_share"},
      {[](Scene& s) -> double& { return s.shading.silhouette; }, "shading.silhouette"},
      {[](Scene& s) -> double& { return s.quality.step_voxels; }, "quality.step_voxels"},
      {[](Scene& s) -> double& { return s.quality.opaque_at; }, "quality.opaque_at"},
      {[](Scene& s) -> double& { return s.quality.pixel_error; }, "quality.pixel_error"},
      {[](Scene& s) -> double& { return s.background_rgb.z(); }, "background_rgb"},
      {[](Scene& s) -> double& { return s.grey.level_hu; }, "grey.level_hu"},
      {[](Scene& s) -> double& { return s.grey.width_hu; }, "grey.width_hu"},
      {[](Scene& s) -> double& { return s.plane->opacity; }, "plane.opacity"},
      {[](Scene& s) -> double& { return s.plane->frame.grid.origin_mm.y(); }, "plane.frame"},
      {[](Scene& s) -> double& { return s.plane->frame.grid.mm_per_pixel(0, 1); }, "plane.frame"},
      {[](Scene& s) -> double& { return s.plane->frame.outline->apex_mm.y(); }, "apex_mm"},
      {[](Scene& s) -> double& { return s.plane->frame.outline->radius_min_mm; }, "radius_min_mm"},
      {[](Scene& s) -> double& { return s.plane->frame.outline->radius_max_mm; }, "radius_max_mm"},
      {[](Scene& s) -> double& { return s.plane->frame.outline->half_angle_rad; },
       "half_angle_rad"},
      {[](Scene& s) -> double& { return s.needle->tip_ct.mm.x(); }, "needle.tip_ct"},
      {[](Scene& s) -> double& { return s.needle->hub_ct.mm.y(); }, "needle.hub_ct"},
      {[](Scene& s) -> double& { return s.needle->radius_mm; }, "needle.radius_mm"},
      {[](Scene& s) -> double& { return s.needle->rgb.z(); }, "needle.rgb"},
      {[](Scene& s) -> double& { return s.spheres[0].centre_ct.mm.x(); }, "spheres[0].centre_ct"},
      {[](Scene& s) -> double& { return s.spheres[0].radius_mm; }, "spheres[0].radius_mm"},
      {[](Scene& s) -> double& { return s.spheres[0].rgb.y(); }, "spheres[0].rgb"},
      {[](Scene& s) -> double& { return s.spheres[0].opacity; }, "spheres[0].opacity"},
      {[](Scene& s) -> double& { return s.lines[0].from_ct.mm.x(); }, "lines[0].from_ct"},
      {[](Scene& s) -> double& { return s.lines[0].to_ct.mm.y(); }, "lines[0].to_ct"},
      {[](Scene& s) -> double& { return s.lines[0].radius_mm; }, "lines[0].radius_mm"},
      {[](Scene& s) -> double& { return s.lines[0].rgb.y(); }, "lines[0].rgb"},
      {[](Scene& s) -> double& { return s.lines[0].opacity; }, "lines[0].opacity"},
      {[](Scene& s) -> double& { return s.cutaway->theta1_rad; }, "cutaway.theta1_rad"},
      {[](Scene& s) -> double& { return s.cutaway->theta2_rad; }, "cutaway.theta2_rad"},
      {[](Scene& s) -> double& { return s.cutaway->overlay_mm; }, "cutaway.overlay_mm"},
      {[](Scene& s) -> double& { return s.cutaway->boxes[0].centre_ct.mm.z(); }, "boxes[0].centre"},
      {[](Scene& s) -> double& { return s.cutaway->boxes[0].half_edges_ct(2, 2); },
       "half_edges_ct"},
  };
  for (const Number& number : numbers) {
    Scene scene = full_scene();
    number.in(scene) = kNan;
    EXPECT_TRUE(test::rejects(validate(scene), ErrorCode::kMalformedData, {number.field}))
        << number.field;
  }
}

TEST(ValidateSceneTest, RejectsPositionsThatAreTooFarAway) {
  const auto rejects = [](auto change, const std::string& field) {
    Scene scene = full_scene();
    change(scene);
    return test::rejects(validate(scene), ErrorCode::kMalformedData, {field});
  };
  const double far_mm = 2e7;
  const auto with_pose_at = [](const Eigen::Vector3d& mm) {
    return [mm](Scene& s) { s.plane->ct_from_image = {s.plane->ct_from_image.rotation(), mm}; };
  };
  EXPECT_TRUE(rejects(with_pose_at({0, far_mm, 0}), "plane.ct_from_image"));
  EXPECT_TRUE(rejects([&](Scene& s) { s.spheres[0].centre_ct.mm.z() = far_mm; }, "centre_ct"));
  EXPECT_TRUE(rejects([&](Scene& s) { s.needle->hub_ct.mm.z() = far_mm; }, "needle.hub_ct"));
  EXPECT_TRUE(rejects(
      [&](Scene& s) {
        VoxelGrid grid = s.ct->grid();
        grid.origin_mm.x() = far_mm;
        s.ct = test::make_volume(grid, [](int, int, int) { return 0; });
      },
      "ct.grid.origin_mm"));
}

TEST(ValidateSceneTest, AcceptsTheLimitsOfACutaway) {
  const auto accepts = [](auto change) {
    Scene scene = full_scene();
    change(*scene.cutaway);
    return test::has_value(validate(scene));
  };
  EXPECT_TRUE(accepts([](Cutaway& c) { c.theta1_rad = c.theta2_rad; })) << "simple cutaway";
  EXPECT_TRUE(accepts([](Cutaway& c) { c.overlay_mm = 0; }));
  EXPECT_TRUE(accepts([](Cutaway& c) { c.overlay_mm = std::numeric_limits<double>::infinity(); }));
  EXPECT_TRUE(accepts([](Cutaway& c) { c.theta1_rad = 1e-3; }));
  EXPECT_TRUE(accepts([](Cutaway& c) { c.polygons[0].vertices_ct.resize(2); })) << "a segment";
  EXPECT_TRUE(accepts([](Cutaway& c) {
    auto& v = c.polygons[0].vertices_ct;  // On a line with numbers that are not round.
    v = {{{0.1, 0.7, 0.3}}, {{100.3, 33.1, 77.7}}};
    v.push_back({v[0].mm + 0.37 * (v[1].mm - v[0].mm)});
    v.push_back({v[0].mm + 0.11 * (v[1].mm - v[0].mm)});
  }));
  EXPECT_TRUE(accepts([](Cutaway& c) { c.boxes[0].half_edges_ct.col(0) *= -1; })) << "left-handed";
}

TEST(ValidateSceneTest, IgnoresTheFieldsOfLostObjects) {
  Scene scene = full_scene();
  scene.plane->safety = {SafetyState::kLost, "no pose"};
  scene.plane->frame.pixels = {};
  scene.needle->safety = {SafetyState::kLost, "no pose"};
  scene.needle->tip_ct.mm.x() = kNan;
  EXPECT_TRUE(test::has_value(validate(scene)));
  EXPECT_TRUE(test::has_value(make_cpu_engine()->render(scene)));
}

TEST(To8BitTest, RoundsToNearestAndClamps) {
  const Image2d<RgbaF> image(
      2, 1, {{0.0F, 0.49F / 255, 0.51F / 255, 1.0F}, {-1.0F, 2.0F, 254.4F / 255, 1.0F}});
  const auto bytes = to_8bit(image);
  EXPECT_EQ(bytes.at(0, 0), (Rgba8{0, 0, 1, 255}));
  EXPECT_EQ(bytes.at(1, 0), (Rgba8{0, 255, 254, 255}));
}

}  // namespace
}  // namespace nav::render
