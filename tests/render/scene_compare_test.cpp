// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/scene_compare.hpp"

#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <vector>

#include "tests/render/predicates/predicate_scenes.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

using Edit = std::function<void(Scene&)>;

/// A scene with one object of each kind.
Scene full_scene() {
  const auto ct = test::make_volume(test::centred_grid({4, 4, 4}, {1, 1, 1}),
                                    [](int, int, int) { return 0.0; });
  Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(100, 10, false));
  std::vector<TransferComponent> components = scene.transfer.components();
  components[0].gradient = GradientWindow{1, 2, 3, 4};
  scene.transfer = *TransferFunction::blend("windowed", std::move(components));
  scene.plane = test::upright_plane(test::grey_image(4, 4, 100), 1, {0, 0, 0});
  scene.plane->frame.outline = SectorOutline{{0, -1}, 1, 9, 0.3};
  scene.needle = test::needle({0, 0, 0}, {0, 9, 0});
  scene.spheres.push_back({{{0, 0, 0}}});
  scene.lines.push_back({{{0, 0, 0}}, {{1, 0, 0}}});
  scene.cutaway.emplace();
  scene.cutaway->polygons.push_back({{{{0, 0, 0}}, {{5, 0, 0}}, {{0, 5, 0}}}});
  scene.cutaway->boxes.push_back({{{0, 0, 0}}, Eigen::Matrix3d::Identity()});
  scene.cutaway->meshes.push_back(std::make_shared<const MeshObject>());
  return scene;
}

/// Applies each edit alone. In both directions it must be a change of the given kind.
void expect_each(const Scene& before, SceneChange change, const std::vector<Edit>& edits) {
  for (std::size_t i = 0; i < edits.size(); ++i) {
    Scene after = before;
    edits[i](after);
    EXPECT_EQ(change_between(before, after), change) << "edit " << i;
    EXPECT_EQ(change_between(after, before), change) << "edit " << i << ", undone";
  }
}

/// Edits a transfer function by a rebuild, because it is immutable.
Edit with_transfer(const std::function<void(TransferComponent&)>& edit) {
  return [edit](Scene& s) {
    std::vector<TransferComponent> components = s.transfer.components();
    edit(components[0]);
    s.transfer = *TransferFunction::blend(s.transfer.name(), std::move(components));
  };
}

TEST(SceneChangeTest, TheSameSceneIsNoChange) {
  expect_each(full_scene(), SceneChange::kNothing,
              {[](Scene&) {}, [](Scene& s) { s.plane->frame.sequence = 7; },
               [](Scene& s) { s.quality.provisional = true; },
               [](Scene& s) { s.plane->frame.pixels = test::grey_image(4, 4, 100); }});
}

TEST(SceneChangeTest, NewPixelsAloneCastNoRay) {
  expect_each(full_scene(), SceneChange::kPixels,
              {[](Scene& s) { s.plane->frame.pixels = test::grey_image(4, 4, 9); }});
}

// A field that this list lacks would not update the image.
TEST(SceneChangeTest, EachFieldOfASurfaceOrObjectChangesTheGeometry) {
  expect_each(
      full_scene(), SceneChange::kGeometry,
      {[](Scene& s) { s.plane.reset(); },
       [](Scene& s) { s.plane->opacity = 0.5; },
       [](Scene& s) { s.plane->safety.state = SafetyState::kDegraded; },
       [](Scene& s) { s.plane->safety.state = SafetyState::kStale; },
       [](Scene& s) { s.plane->safety.state = SafetyState::kLost; },
       [](Scene& s) { s.plane->frame.pixels = test::grey_image(5, 4, 100); },
       [](Scene& s) { s.plane->frame.pixels = test::grey_image(4, 5, 100); },
       [](Scene& s) { s.plane->frame.grid.origin_mm.x() += 1; },
       [](Scene& s) { s.plane->frame.grid.mm_per_pixel(0, 1) += 0.1; },
       [](Scene& s) { s.plane->frame.outline.reset(); },
       [](Scene& s) { s.plane->frame.outline->apex_mm.x() += 1; },
       [](Scene& s) { s.plane->frame.outline->radius_min_mm += 1; },
       [](Scene& s) { s.plane->frame.outline->radius_max_mm += 1; },
       [](Scene& s) { s.plane->frame.outline->half_angle_rad += 0.1; },
       [](Scene& s) {
         s.plane->ct_from_image = {s.plane->ct_from_image.rotation(), Eigen::Vector3d(0, 0, 1)};
       },
       [](Scene& s) {
         s.plane->ct_from_image = {
             Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ())),
             s.plane->ct_from_image.translation_mm()};
       },
       [](Scene& s) { s.needle.reset(); },
       [](Scene& s) { s.needle->tip_ct.mm.x() += 1; },
       [](Scene& s) { s.needle->hub_ct.mm.x() += 1; },
       [](Scene& s) { s.needle->radius_mm += 1; },
       [](Scene& s) { s.needle->rgb.x() = 0; },
       [](Scene& s) { s.needle->safety.state = SafetyState::kStale; },
       [](Scene& s) { s.spheres.clear(); },
       [](Scene& s) { s.spheres.push_back(s.spheres[0]); },
       [](Scene& s) { s.spheres[0].centre_ct.mm.x() += 1; },
       [](Scene& s) { s.spheres[0].radius_mm += 1; },
       [](Scene& s) { s.spheres[0].rgb.x() = 0; },
       [](Scene& s) { s.spheres[0].opacity = 0.5; },
       [](Scene& s) { s.lines.clear(); },
       [](Scene& s) { s.lines[0].from_ct.mm.x() += 1; },
       [](Scene& s) { s.lines[0].to_ct.mm.x() += 1; },
       [](Scene& s) { s.lines[0].radius_mm += 1; },
       [](Scene& s) { s.lines[0].rgb.x() = 0; },
       [](Scene& s) { s.lines[0].opacity = 0.5; },
       [](Scene& s) { s.cutaway.reset(); },
       [](Scene& s) { s.cutaway->theta1_rad -= 0.1; },
       [](Scene& s) { s.cutaway->theta2_rad += 0.1; },
       [](Scene& s) { s.cutaway->overlay_mm += 1; },
       [](Scene& s) { s.cutaway->around_plane = false; },
       [](Scene& s) { s.cutaway->around_needle = true; },
       [](Scene& s) { s.cutaway->around_spheres = true; },
       [](Scene& s) { s.cutaway->polygons.clear(); },
       [](Scene& s) { s.cutaway->polygons[0].vertices_ct[2].mm.x() += 1; },
       [](Scene& s) { s.cutaway->polygons[0].vertices_ct.pop_back(); },
       [](Scene& s) { s.cutaway->boxes.clear(); },
       [](Scene& s) { s.cutaway->boxes[0].centre_ct.mm.x() += 1; },
       [](Scene& s) { s.cutaway->boxes[0].half_edges_ct *= 2; },
       [](Scene& s) { s.cutaway->meshes.clear(); },
       [](Scene& s) { s.cutaway->meshes[0] = std::make_shared<const MeshObject>(); }});
}

TEST(SceneChangeTest, EachFieldOfViewVolumeAndAppearanceChangesTheView) {
  expect_each(full_scene(), SceneChange::kView,
              {[](Scene& s) { s.ct = std::make_shared<StoredVolume>(*s.ct); },
               [](Scene& s) { s.width += 1; },
               [](Scene& s) { s.height += 1; },
               [](Scene& s) { s.background_rgb.z() = 1; },
               [](Scene& s) { s.projection = Projection::kMaximum; },
               [](Scene& s) { s.grey.level_hu += 1; },
               [](Scene& s) { s.grey.width_hu += 1; },
               [](Scene& s) { s.camera.eye_ct.mm.x() += 1e-9; },
               [](Scene& s) { s.camera.look_at_ct.mm.x() += 1e-9; },
               [](Scene& s) { s.camera.up_ct.v.x() += 1e-9; },
               [](Scene& s) { s.camera.vertical_fov_rad += 1e-9; },
               [](Scene& s) { s.camera.orthographic = true; },
               [](Scene& s) { s.camera.orthographic_height_mm += 1; },
               [](Scene& s) { s.shading.enabled = !s.shading.enabled; },
               [](Scene& s) { s.shading.style = ShadingStyle::kGooch; },
               [](Scene& s) { s.shading.emphasis += 0.1; },
               [](Scene& s) { s.shading.full_gradient_per_mm += 1; },
               [](Scene& s) { s.shading.ambient += 0.1; },
               [](Scene& s) { s.shading.diffuse += 0.1; },
               [](Scene& s) { s.shading.specular += 0.1; },
               [](Scene& s) { s.shading.shininess += 1; },
               [](Scene& s) { s.shading.cool_share += 0.1; },
               [](Scene& s) { s.shading.warm_share += 0.1; },
               [](Scene& s) { s.shading.silhouette -= 0.1; },
               [](Scene& s) { s.quality.step_voxels += 0.1; },
               [](Scene& s) { s.quality.classification = Classification::kPostClassified; },
               [](Scene& s) { s.quality.opaque_at -= 0.1; },
               [](Scene& s) { s.quality.skip_empty_bricks = !s.quality.skip_empty_bricks; },
               [](Scene& s) { s.quality.jitter = !s.quality.jitter; },
               [](Scene& s) { s.quality.pixel_error += 0.1; },
               with_transfer([](TransferComponent& c) { c.nodes[0].hu -= 1; }),
               with_transfer([](TransferComponent& c) { c.nodes[0].rgb.x() *= 0.5; }),
               with_transfer([](TransferComponent& c) { c.nodes[0].opacity *= 0.5; }),
               with_transfer([](TransferComponent& c) { c.nodes[0].importance *= 0.5; }),
               with_transfer([](TransferComponent& c) {
                 c.nodes.push_back({1e4, {0, 0, 0}, 0, 0});
               }),
               with_transfer([](TransferComponent& c) { c.gradient.reset(); }),
               with_transfer([](TransferComponent& c) { c.gradient->zero_below += 0.5; }),
               with_transfer([](TransferComponent& c) { c.gradient->full_from += 0.5; }),
               with_transfer([](TransferComponent& c) { c.gradient->full_to += 0.5; }),
               with_transfer([](TransferComponent& c) { c.gradient->zero_above += 0.5; }),
               [](Scene& s) {
                 auto components = s.transfer.components();
                 components.push_back(components[0]);
                 s.transfer = *TransferFunction::blend("two", std::move(components));
               }});
}

Scene predicate_scene() {
  Scene scene = full_scene();
  PredicateScene& p = scene.predicates.emplace();
  p.model = test::model_of({{PredicateExpression::kind("intensity", {0.2, 1}), 0.5},
                            {PredicateExpression::kind("depth", {0, 5}), 0.5}});
  const auto feature = [](int i, int, int) { return static_cast<double>(i); };
  p.features.volumes.emplace("snr", test::feature(scene.ct->grid(), "snr", feature));
  p.features.labels =
      *LabelVolume::create(scene.ct->grid(), std::vector<std::uint32_t>(64, 1), "labels");
  p.scan = ParallelScan{{{0, 0, 0}}, {{0, 1, 0}}};
  return scene;
}

/// Edits the predicates only.
Edit of_model(const std::function<void(PredicateScene&)>& edit) {
  return [edit](Scene& s) { edit(*s.predicates); };
}

TEST(SceneChangeTest, EachFieldOfPredicatesChangesTheView) {
  const Scene before = predicate_scene();
  expect_each(
      before, SceneChange::kView,
      {[](Scene& s) { s.predicates.reset(); },
       of_model([](PredicateScene& p) { p.intensity.black -= 1; }),
       of_model([](PredicateScene& p) { p.intensity.white += 1; }),
       of_model([](PredicateScene& p) { p.opacity_length_mm += 1; }),
       of_model([](PredicateScene& p) { p.hue_mean = spec::HueMean::kLinear; }),
       of_model([](PredicateScene& p) { p.cutaway_importance += 0.1; }),
       of_model([](PredicateScene& p) { p.termination_error += 0.1; }),
       of_model([](PredicateScene& p) { p.needle_lost = true; }),
       of_model([](PredicateScene& p) { p.model.histogram.drag(0, 0.7); }),
       of_model([](PredicateScene& p) { p.model.histogram.set_colour(0, 33, 0.6); }),
       of_model([](PredicateScene& p) { p.model.histogram.set_colour(0, 0, 0.7); }),
       of_model([](PredicateScene& p) { p.model.entries[0].expression.values[1] = 0.9; }),
       of_model([](PredicateScene& p) { p.model.entries[0].expression.name = "snr"; }),
       of_model([](PredicateScene& p) {
         p.model.entries[0].expression =
             PredicateExpression::negation(p.model.entries[0].expression);
       }),
       of_model([](PredicateScene& p) { p.features.volumes.clear(); }),
       of_model([](PredicateScene& p) {
         auto& volumes = p.features.volumes;
         volumes.emplace("vesselness", volumes.at("snr"));
       }),
       of_model([](PredicateScene& p) {
         const FeatureVolume& old = p.features.volumes.at("snr");
         const auto feature = [](int i, int, int) { return static_cast<double>(i); };
         p.features.volumes.insert_or_assign("snr", test::feature(old.grid(), "snr", feature));
       }),
       of_model([](PredicateScene& p) { p.features.labels.reset(); }),
       of_model([](PredicateScene& p) {
         p.features.labels = *LabelVolume::create(p.features.labels->grid(),
                                                  std::vector<std::uint32_t>(64, 1), "labels");
       }),
       of_model([](PredicateScene& p) { p.scan.reset(); }),
       of_model([](PredicateScene& p) {
         p.scan = FanScan{{{0, 0, 0}}, 0};
       }),
       of_model([](PredicateScene& p) { std::get<ParallelScan>(*p.scan).face_ct.mm.y() += 1; }),
       of_model([](PredicateScene& p) { std::get<ParallelScan>(*p.scan).into_ct.v.x() += 1; })});
}

TEST(SceneChangeTest, EachFieldOfScanLinesChangesTheView) {
  Scene before = predicate_scene();
  before.predicates->scan = FanScan{{{0, -9, 0}}, 4};
  expect_each(
      before, SceneChange::kView,
      {of_model([](PredicateScene& p) { std::get<FanScan>(*p.scan).apex_ct.mm.x() += 1; }),
       of_model([](PredicateScene& p) { std::get<FanScan>(*p.scan).face_radius_mm += 1; })});
  const std::vector<Eigen::Vector3f> down(64, Eigen::Vector3f::UnitY());
  before.predicates->scan = VoxelScan{std::make_shared<const std::vector<Eigen::Vector3f>>(down)};
  expect_each(before, SceneChange::kView, {of_model([&](PredicateScene& p) {
                p.scan = VoxelScan{std::make_shared<const std::vector<Eigen::Vector3f>>(down)};
              })});
}

}  // namespace
}  // namespace nav::render
