// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests labels between B-spline surfaces. The reference uses the exact surfaces, the other engines
// use the raster.
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>

#include "render/engine.hpp"
#include "render/features/labels.hpp"
#include "tests/render/predicates/predicate_scenes.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;
using features::LayerModel;
using features::LayerSurface;

constexpr double kSideMm = 16;
constexpr int kControl = 9;

/// Heights of the control points in mm along j, over a box of kSideMm. The layer is wavy, between 5
/// and 11 mm.
double control_mm(int u, int v, double base) {
  return base + 1.5 * std::sin(0.9 * u + 0.4 * v) + 0.7 * std::cos(1.1 * v);
}

VoxelGrid grid_of(double spacing_mm) {
  const int side = static_cast<int>(kSideMm / spacing_mm) + 1;
  return test::centred_grid({side, side, side}, {spacing_mm, spacing_mm, spacing_mm},
                            Eigen::Matrix3d::Identity());
}

/// Labels of layers between two surfaces, which have the same positions in mm on all grids.
LabelVolume layers_on(const VoxelGrid& grid) {
  std::vector<LayerSurface> surfaces;
  for (const double base : {5.0, 10.0}) {
    std::vector<double> heights;
    for (int v = 0; v < kControl; ++v) {
      for (int u = 0; u < kControl; ++u) {
        heights.push_back(control_mm(u, v, base) / grid.spacing_mm.y());
      }
    }
    surfaces.push_back(*LayerSurface::create(1, grid.size, {kControl, kControl}, heights));
  }
  const auto model = std::make_shared<const LayerModel>(*LayerModel::create(surfaces));
  return LabelVolume::create(grid, model->rasterise(grid)->masks(), "layers")->with_layers(model);
}

Scene scene_of(double spacing_mm, bool exact) {
  const VoxelGrid grid = grid_of(spacing_mm);
  Scene scene = test::plain_scene(test::make_volume(grid, [](int, int, int) { return 60; }),
                                  test::fog(0.1), test::frontal(60, 20, false));
  PredicateScene predicates;
  predicates.model = test::model_of(
      {{E::kind("label", {1}), 0.2}, {E::kind("label", {2}), 0.5}, {E::kind("label", {4}), 0.3}});
  predicates.features.labels = layers_on(grid);
  if (!exact) predicates.features.labels = predicates.features.labels->with_layers(nullptr);
  scene.predicates = predicates;
  return scene;
}

/// Share of the positions in the box for which the raster and the surfaces give different entries.
double differing(double spacing_mm) {
  const Scene exact = scene_of(spacing_mm, true);
  const Scene raster = scene_of(spacing_mm, false);
  const auto exact_set = *PredicateSet::create(*exact.predicates, exact.ct, position_of(exact));
  const auto raster_set = *PredicateSet::create(*raster.predicates, raster.ct, position_of(raster));
  const PredicateSampler by_surfaces(exact_set);
  const PredicateSampler by_voxels(raster_set);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, kSideMm / spacing_mm);
  constexpr int kSamples = 200000;
  int other = 0;
  for (int n = 0; n < kSamples; ++n) {
    const Eigen::Vector3d at(unit(random), unit(random), unit(random));
    other += by_surfaces.mask(at) != by_voxels.mask(at) ? 1 : 0;
  }
  return 1.0 * other / kSamples;
}

TEST(LayerSurfacesTest, TheReferenceUsesTheSurfaceNotTheVoxel) {
  const Scene scene = scene_of(2, true);
  const auto set = *PredicateSet::create(*scene.predicates, scene.ct, position_of(scene));
  const PredicateSampler sampler(set);
  const LayerModel& model = *scene.predicates->features.labels->layers();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, kSideMm / 2);
  for (int n = 0; n < 2000; ++n) {
    const Eigen::Vector3d at(unit(random), unit(random), unit(random));
    ASSERT_EQ(sampler.mask(at), 1U << model.layer_at(at)) << at.transpose();
  }
}

TEST(LayerSurfacesTest, TheErrorOfTheRasterFallsWithTheVoxelSize) {
  double before = 0;
  for (const double spacing_mm : {2.0, 1.0, 0.5, 0.25}) {
    const double share = differing(spacing_mm);
    std::printf("voxels of %.2f mm: %.2f %% of samples differ\n", spacing_mm, 100 * share);
    EXPECT_GT(share, 0);
    // With half the voxel size, half as many samples differ, because the uncertain layer is half as
    // thick.
    if (before > 0) {
      EXPECT_NEAR(share / before, 0.5, 0.06) << spacing_mm;
    }
    before = share;
  }
}

TEST(LayerSurfacesTest, ImagesOfTheRasterConvergeToTheReference) {
  const auto reference = make_reference_engine({.threads = 2});
  double before = 1;
  for (const double spacing_mm : {2.0, 1.0, 0.5}) {
    Scene exact = scene_of(spacing_mm, true);
    Scene raster = scene_of(spacing_mm, false);
    for (Scene* scene : {&exact, &raster}) {
      scene->width = 48;
      scene->height = 48;
      scene->quality.step_voxels = 0.25 / spacing_mm;  // The sample positions are equal for every
                                                       // grid.
    }
    const auto a = reference->render(exact);
    const auto b = reference->render(raster);
    ASSERT_TRUE(test::has_value(a));
    ASSERT_TRUE(test::has_value(b));
    const double rms = rms_difference(a->pixels, b->pixels);
    std::printf("voxels of %.2f mm: images differ by %.5f rms\n", spacing_mm, rms);
    EXPECT_GT(rms, 0);
    EXPECT_LT(rms, 0.75 * before);
    before = rms;
  }
}

TEST(LayerSurfacesTest, ScribblesCountVoxelsLikeTheRaster) {
  const Scene exact = scene_of(1, true);
  const Scene raster = scene_of(1, false);
  std::vector<std::size_t> voxels(exact.ct->grid().voxel_count());
  for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = i;
  const auto count = [&](const Scene& scene) {
    return count_true(*PredicateSet::create(*scene.predicates, scene.ct, position_of(scene)),
                      voxels);
  };
  EXPECT_EQ(count(exact), count(raster));
}

}  // namespace
}  // namespace nav::render
