// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "bench/derived.hpp"
#include "bench/predicate_bench.hpp"
#include "bench/predicate_cases.hpp"
#include "bench/render_costs.hpp"
#include "bench/render_live.hpp"
#include "bench/scene_set.hpp"
#include "bench/whole_scene.hpp"
#include "render/features/confidence.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::bench {
namespace {

/// A small patient with every element that a navigation image can have.
render::Scene everything() {
  const auto ct = test::make_volume(
      test::centred_grid({40, 40, 40}, {1, 1, 1}),
      [](int i, int j, int k) { return 300 * std::sin(0.3 * i) * std::cos(0.2 * j + 0.1 * k); });
  const auto transfer = render::TransferFunction::create(
      "tissue", {{0, {0.9, 0.6, 0.5}, 0, 0.2}, {300, {1, 0.9, 0.8}, 0.3, 0.9}});
  render::Scene scene = test::plain_scene(ct, *transfer, test::frontal(120, 50, false));
  scene.shading.enabled = true;
  scene.plane = test::upright_plane(test::grey_image(20, 16, 120), 1, {0, 0, 8});
  scene.needle = test::needle({0, 0, 0}, {20, -30, 20});
  scene.spheres.push_back({{{0, 0, 0}}, 4});
  scene.lines.push_back({{{0, 0, 0}}, {{20, -30, 20}}});
  scene.cutaway = render::Cutaway{};
  return scene;
}

TEST(PredicateBenchReportTest, ValuesThatNoSceneMeasuredAreNan) {
  PredicateBenchReport report;
  EXPECT_TRUE(std::isnan(report.max_error()));
  EXPECT_TRUE(std::isnan(report.worst_set_edit_wall_ms()));
  EXPECT_TRUE(std::isnan(report.predicate_over_standard()));
  EXPECT_FALSE(report.megabytes.has_value());
  report.rows.emplace_back();
  report.rows.back().max_error = 0.25;
  report.rows.back().edit.first_ms = 7;
  EXPECT_EQ(report.max_error(), 0.25);
  EXPECT_EQ(report.worst_set_edit_wall_ms(), 7);
}

TEST(PredicateBenchTest, MeasuresTheMemoryOfAnEngineAndAnEditOfThePredicateSet) {
  constexpr int kSide = 96;
  PredicateBenchOptions options;
  options.side = kSide;
  options.width = 48;
  options.height = 36;
  options.repeats = {1, 0};
  options.volume = "neck";
  options.appearance = "vessel";  // The only appearance, so no other predicate set can be the first
                                  // of the volume.
  options.gl = false;
  CollectingDiagnostics diagnostics;
  const auto report = measure_predicates(options, diagnostics);
  ASSERT_TRUE(test::has_value(report));
  ASSERT_EQ(report->rows.size(), 1U);
  const PredicateBenchRow& row = report->rows.front();
  // The engine holds 32 bits for each voxel of the volume and of vesselness (CpuVolume).
  constexpr double kVoxels = 1.0 * kSide * kSide * kSide;
  EXPECT_GT(row.engine_bytes, 8 * kVoxels);
  EXPECT_LT(row.engine_bytes, 12 * kVoxels);
  EXPECT_EQ(report->megabytes, 1e-6 * row.engine_bytes);
  // A new predicate set must test its bricks. A new importance only weights them.
  EXPECT_GT(row.set_edit_ms, row.prepare_ms);
}

TEST(ConfidenceOfPhantomsTest, EstimatesItsErrorWithinAFactor) {
  using namespace render::features;
  constexpr double kFactor = 2.5;
  const auto neck = neck_phantom(64);
  ASSERT_TRUE(test::has_value(neck));
  for (const ScalarVolume& volume : {derived_phantom(64), ScalarVolume::of(neck->ultrasound)}) {
    const auto lines = ScanLines::parallel({{0, 1, 0}}, volume.grid().at({0, 0, 0}));
    ConfidenceOptions options;
    const auto found = confidence(volume, *lines, options);
    options.solve = {1e-9, 2000};
    const auto truth = confidence(volume, *lines, options);
    ASSERT_TRUE(test::has_value(found));
    ASSERT_TRUE(test::has_value(truth));
    double squares = 0;
    for (std::size_t n = 0; n < truth->volume.values->size(); ++n) {
      const float apart = (*truth->volume.values)[n] - (*found->volume.values)[n];
      squares += static_cast<double>(apart * apart);
    }
    const double rms = std::sqrt(squares / static_cast<double>(truth->volume.values->size()));
    EXPECT_LT(rms, kFactor * found->report.estimated_error) << volume.name();
    EXPECT_GT(rms, found->report.estimated_error / kFactor) << volume.name();
  }
}

TEST(SceneSetTest, HasEveryAppearanceCameraAndShadingUnderItsOwnName) {
  const BenchVolume volume{"v", everything().ct, {vessels_only(), test::fog(0.1)}};
  std::set<std::string> names;
  for (const NamedScene& named : bench_scenes({volume}, "", 32, 24)) {
    names.insert(named.name);
    EXPECT_TRUE(test::has_value(render::validate(named.scene))) << named.name;
  }
  EXPECT_EQ(names.size(), 8U);
  EXPECT_EQ(names.count("v/vessels-only/orthographic/shaded"), 1U);
  EXPECT_EQ(bench_scenes({volume}, "fog/persp", 32, 24).size(), 2U);
  EXPECT_TRUE(bench_scenes({volume}, "w/", 32, 24).empty());
}

TEST(SceneSetTest, ReportsMissingVolumes) {
  CollectingDiagnostics diagnostics;
  const auto volumes = bench_volumes("aorta", "/no such folder", diagnostics);
  ASSERT_TRUE(test::has_value(volumes));
  EXPECT_TRUE(volumes->empty());
  ASSERT_EQ(diagnostics.entries().size(), 1U);
  EXPECT_NE(diagnostics.entries()[0].message.find("aorta skipped"), std::string::npos);
  EXPECT_NE(diagnostics.entries()[0].message.find("SONDE_DATA_DIR"), std::string::npos);
}

TEST(RenderCostsTest, IdleElementsTakeNoSampleAndNoGradient) {
  render::Scene scene = everything();
  // The volume is visible everywhere. If the midpoints of a cell are invisible, its importance
  // counts as 1.
  scene.transfer = *render::TransferFunction::create(
      "tissue", {{-300, {0.9, 0.6, 0.5}, 0.01, 0.2}, {300, {1, 0.9, 0.8}, 0.3, 0.9}});
  const auto table = measure_costs(scene, {1, 0});
  ASSERT_TRUE(test::has_value(table));
  int idle = 0;
  for (const ElementCost& cost : table->elements) {
    if (!cost.has_idle) continue;
    ++idle;
    EXPECT_EQ(cost.idle_samples, 0) << cost.element;
    EXPECT_EQ(cost.idle_gradients, 0) << cost.element;
  }
  EXPECT_GE(idle, 6);
  EXPECT_GT(table->frame_samples, 0U);
  EXPECT_GT(table->elements.front().samples, 0) << "the volume itself";
}

TEST(RenderCostsTest, AnUnchangedSceneAndANewImageTakeNoSample) {
  const auto table = measure_costs(everything(), {2, 0});
  ASSERT_TRUE(test::has_value(table));
  for (const char* change : {"nothing", "new ultrasound image, same pose"}) {
    const auto found = std::find_if(table->changes.begin(), table->changes.end(),
                                    [&](const ChangeCost& cost) { return cost.change == change; });
    ASSERT_NE(found, table->changes.end()) << change;
    EXPECT_EQ(found->samples, 0U) << change;
    EXPECT_EQ(found->gradients, 0U) << change;
  }
}

TEST(RenderCostsTest, EverySceneCanBeMeasuredWithAllElements) {
  const BenchVolume volume{"v", everything().ct, {vessels_only(), test::fog(0.1)}};
  for (const NamedScene& named : bench_scenes({volume}, "", 32, 24)) {
    const render::Scene whole = with_everything(named.scene);
    ASSERT_TRUE(test::has_value(render::validate(whole))) << named.name;
    const auto table = measure_costs(whole, {1, 0});
    ASSERT_TRUE(test::has_value(table)) << named.name;
    // The ultrasound image lies in the CT, in view.
    const Eigen::Vector3d middle =
        (whole.plane->ct_from_image * Point<frames::Image>{{0, 10, 0}}).mm;
    EXPECT_TRUE(whole.ct->sample({middle}).has_value()) << named.name;
  }
}

TEST(PreparationCostsTest, WhatIsNotUsedLeavesTheCtAsItIs) {
  // A ball of tissue in air with a tube of contrast agent.
  const auto values =
      test::make_volume(test::centred_grid({32, 32, 32}, {2, 2, 2}), [](int i, int j, int k) {
        if (std::hypot(i - 16, j - 16, k - 16) > 13) return -1000;
        return std::hypot(i - 16, j - 16) < 3 ? 300 : 40;
      });
  const auto ct = std::make_shared<const Volume>(
      *Volume::create(values->grid(), {values->values().begin(), values->values().end()}, "tube"));
  // An unused part that changes the CT is a Bug.
  const auto costs = measure_preparations(ct, {1, 0});
  ASSERT_TRUE(test::has_value(costs));
  const auto count = [&](const std::string& start) {
    return std::ranges::count_if(*costs, [&](const auto& c) { return c.what.starts_with(start); });
  };
  EXPECT_EQ(count("  unused"), 3);
  EXPECT_EQ(count("  vessels"), 1);
  for (const PreparationCost& cost : *costs) EXPECT_GE(cost.wall_ms, 0) << cost.what;
}

TEST(RenderCostsTest, RejectsASceneWithoutAllElements) {
  render::Scene scene = everything();
  scene.lines.clear();
  EXPECT_TRUE(test::rejects(measure_costs(scene, {}), ErrorCode::kUsage, {"lines"}));
}

TEST(RenderLiveTest, SkippingAndUpdatesGiveIdenticalImages) {
  const auto skip = measure_skipping({"everything", everything()});
  ASSERT_TRUE(test::has_value(skip));
  EXPECT_TRUE(skip->identical);
  EXPECT_LT(skip->on, skip->off);
  const auto update = measure_image_update(everything(), 2);
  ASSERT_TRUE(test::has_value(update));
  EXPECT_TRUE(update->identical);
  EXPECT_EQ(update->samples, 0U);
}

/// Rays along x through a cube of \p side voxels. The voxels in [from, to) along x are slightly
/// visible.
render::Scene slab(int side, int from, int to) {
  VoxelGrid grid;
  grid.size = {side, side, side};
  const auto ct = test::make_volume(
      grid, [&](int i, int, int) { return i >= from && i < to ? 1000.0 : -1000.0; });
  const auto haze =
      render::TransferFunction::create("haze", {{0, {1, 1, 1}, 0, 1}, {900, {1, 1, 1}, 1e-3, 1}});
  render::Camera camera;
  const double middle = 0.5 * side;
  camera.eye_ct = {{-10, middle, middle}};
  camera.look_at_ct = {{0, middle, middle}};
  camera.up_ct = {Eigen::Vector3d::UnitZ()};
  camera.orthographic = true;
  camera.orthographic_height_mm = middle;
  render::Scene scene = test::plain_scene(ct, *haze, camera);
  scene.shading.enabled = false;
  scene.quality.step_voxels = 1;
  scene.width = scene.height = 4;
  return scene;
}

TEST(SkipOracleTest, CountsTheSamplesThatBricksAndCellsLeave) {
  constexpr std::uint64_t kRays = 16;
  const SkipOracle found = skip_oracle(slab(17, 8, 17));
  EXPECT_EQ(found.all, kRays * 17);
  EXPECT_EQ(found.opaque, 0U);
  EXPECT_EQ(found.showing, kRays * 10) << "from the sample at 7 on, which bounds a cell that shows";
  // The brick in front of voxel 8 reaches that voxel, and the cell that runs into that brick is
  // sampled.
  EXPECT_EQ(found.bricks[0].samples, kRays * 17);
  EXPECT_EQ(found.bricks[1].samples, kRays * 14);
  EXPECT_EQ(found.bricks[2].samples, kRays * 12);
  EXPECT_EQ(found.bricks[3].samples, kRays * 11);
  EXPECT_DOUBLE_EQ(found.bricks[1].occupied, 4.0 / 5);
  EXPECT_DOUBLE_EQ(found.bricks[3].occupied, 10.0 / 17);
}

TEST(SkipOracleTest, CountsTheCellThatLeavesABrick) {
  constexpr std::uint64_t kRays = 16;
  const SkipOracle found = skip_oracle(slab(25, 8, 11));
  EXPECT_EQ(found.all, kRays * 25);
  EXPECT_EQ(found.showing, kRays * 5);
  EXPECT_EQ(found.bricks[0].samples, kRays * 17);
  EXPECT_EQ(found.bricks[1].samples, kRays * 10);
  EXPECT_EQ(found.bricks[2].samples, kRays * 8);
  EXPECT_EQ(found.bricks[3].samples, kRays * 6);
}

TEST(SkipOracleTest, EndsWhereARayIsOpaque) {
  render::Scene scene = slab(17, 8, 17);
  scene.quality.opaque_at = 0.0025;  // Exceeded in the fourth cell: 1e-3 for each cell, and a
                                     // quarter for the first one.
  const SkipOracle found = skip_oracle(scene);
  EXPECT_EQ(found.all - found.opaque, 16U * 12);
  EXPECT_EQ(found.showing, 16U * 5);
}

TEST(SkipOracleTest, TheEngineTakesNoFewerSamplesThanNeeded) {
  const auto bound = measure_skip_bound({"half", slab(41, 30, 41)}, 1);
  ASSERT_TRUE(test::has_value(bound));
  EXPECT_TRUE(bound->found.identical);
  EXPECT_GE(bound->found.on, bound->oracle.showing);
  EXPECT_LT(bound->found.on, bound->found.off);
  EXPECT_LE(bound->on_ms, 1e3);
}

}  // namespace
}  // namespace nav::bench
