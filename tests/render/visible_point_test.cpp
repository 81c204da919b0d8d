// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/visible_point.hpp"

#include <gtest/gtest.h>

#include "render/predicates/volume_scene.hpp"

namespace nav::render {
namespace {

constexpr double kStepMm = 0.6;  // Half a voxel, and the border between two voxels.

VoxelGrid grid_of_slab() {
  VoxelGrid grid;
  grid.size = {41, 41, 41};
  grid.origin_mm = {-20, -20, 100};
  return grid;
}

/// Dense from z = 120 mm on, air before it.
std::shared_ptr<const Volume> slab(std::int16_t air = -1000, std::int16_t dense = 1000) {
  const VoxelGrid grid = grid_of_slab();
  std::vector<std::int16_t> values(grid.voxel_count(), air);
  for (std::size_t i = values.size() * 20 / 41; i < values.size(); ++i) values[i] = dense;
  return std::make_shared<const Volume>(*Volume::create(grid, std::move(values), "slab"));
}

Scene slab_scene() {
  return {.ct = slab(),
          .transfer = *TransferFunction::create(
              "dense", {{-10, {1, 1, 1}, 0, 0.2}, {10, {1, 1, 1}, 0.99, 0.2}}),
          .camera = {.eye_ct = {{0, 0, 0}},
                     .look_at_ct = {{0, 0, 120}},
                     .up_ct = {{0, -1, 0}},
                     .orthographic = true,
                     .orthographic_height_mm = 100},
          .width = 100,
          .height = 100};
}

TEST(VisiblePointTest, IsTheSurfaceOfTheVolumeUnderThePixel) {
  const auto middle = *visible_point(slab_scene(), 50, 50);
  ASSERT_TRUE(middle);
  EXPECT_NEAR(middle->mm.z(), 119.5, kStepMm);
  EXPECT_NEAR(middle->mm.x(), 0.5, 1e-9);
  const auto aside = *visible_point(slab_scene(), 60, 50);
  ASSERT_TRUE(aside);
  EXPECT_NEAR(aside->mm.x(), 10.5, 1e-9);
  EXPECT_FALSE(*visible_point(slab_scene(), 5, 5)) << "beside the volume";
  EXPECT_FALSE(*visible_point(slab_scene(), 100, 5)) << "beside the image";
}

TEST(VisiblePointTest, IsWhatTheCutawayLeaves) {
  Scene scene = slab_scene();
  scene.spheres.push_back({.centre_ct = {{0, 0, 130}}, .radius_mm = 3});
  const auto behind = *visible_point(scene, 50, 50);
  ASSERT_TRUE(behind);
  EXPECT_NEAR(behind->mm.z(), 119.5, kStepMm);
  scene.cutaway.emplace();
  scene.cutaway->overlay_mm = 0;
  scene.cutaway->around_spheres = true;
  const auto freed = *visible_point(scene, 50, 50);
  ASSERT_TRUE(freed);
  EXPECT_NEAR(freed->mm.z(), 127, kStepMm) << "the sphere that was cut free";
}

TEST(VisiblePointTest, IsWhatPredicatesShow) {
  const PredicateVolume volume{"slab", slab(0, 255), {}};
  PredicateModel model;
  model.entries.push_back({"bright", PredicateExpression::kind("intensity", {0.5, 1e6})});
  model.histogram.add(0, 0);
  Scene scene = predicate_scene(volume, model, 100, 100);
  scene.camera = slab_scene().camera;
  const auto shown = *visible_point(scene, 50, 50);
  ASSERT_TRUE(shown);
  EXPECT_NEAR(shown->mm.z(), 119.5, 1) << "intensity rises over one voxel";
  scene.predicates->model.entries[0].expression = PredicateExpression::kind("intensity", {2, 3});
  EXPECT_FALSE(*visible_point(scene, 50, 50)) << "nothing is visible";
}

}  // namespace
}  // namespace nav::render
