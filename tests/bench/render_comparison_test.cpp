// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/render_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <gtest/gtest.h>
#include <iostream>

#include "bench/paper_shader.hpp"
#include "bench/predicate_bench_gl.hpp"
#include "bench/predicate_cases.hpp"
#include "bench/predicate_frames.hpp"
#include "bench/vtk_baseline.hpp"
#include "render/engine.hpp"
#include "tests/render/gl/gl_images.hpp"
#include "tests/render/gl/gl_scenes.hpp"
#include "tests/support/matchers.hpp"

namespace nav::bench {
namespace {

NamedScene small_scene(bool shaded) {
  NamedScene named{"ball", test::ball_scene(test::cube_grid(32, 1.0))};
  named.scene.shading.enabled = shaded;
  named.scene.width = 192;  // Three times the size of the reference.
  named.scene.height = 144;
  return named;
}

TEST(RenderComparisonTest, MeasuresEveryEngineAtEveryStep) {
  RenderBenchOptions options;
  options.step_voxels = {1, 0.5};
  options.own_step_voxels = {2};
  options.own_sparse = {{0.5, 0.1}};
  options.repeats = {1, 0};
  options.of_device = false;
  CollectingDiagnostics diagnostics;
  const auto report = compare_renderers({small_scene(false)}, options, diagnostics);
  ASSERT_TRUE(test::has_value(report));
  ASSERT_EQ(report->rows.size(), 15U);  // The last row has the step that was chosen.
  // The limit is loose because VTK classifies after rounding and keeps 8 bits. A wrong camera,
  // transfer function or position gives a ten times larger error.
  constexpr double kSameImage = 0.06;
  for (const RenderBenchRow& row : report->rows) {
    if (row.step > 1) continue;  // Two voxels are a coarse step.
    EXPECT_LT(row.rms, kSameImage) << row.engine << " at " << row.step;
    EXPECT_GE(row.max, row.rms);
    EXPECT_GT(row.cpu_s, 0);
    EXPECT_GT(row.wall_s, 0);
  }
  ASSERT_EQ(report->chosen.size(), 1U);
  const ChosenStep& chosen = report->chosen[0];
  EXPECT_TRUE(chosen.choice.reached);
  EXPECT_LE(chosen.choice.rms, render::kDefaultRms);
  EXPECT_GT(chosen.search_cpu_s, 0);
  EXPECT_LE(chosen.rms_whole, render::kDefaultRms);
  EXPECT_GT(chosen.rms_whole, 0.5 * chosen.choice.rms);
  EXPECT_EQ(report->rows.back().engine, "cpu");
  EXPECT_EQ(report->rows.back().step, chosen.choice.step_voxels);
  EXPECT_EQ(report->ratios.size(), 7U);
  ASSERT_EQ(report->truths.size(), 1U);
  EXPECT_LT(report->truths[0].self_convergence, 1e-3);
  EXPECT_NE(to_text(*report).find("cpu_vs_vtk_fixedpoint"), std::string::npos);
}

TEST(RenderComparisonTest, OurErrorFallsWithTheStep) {
  RenderBenchOptions options;
  options.step_voxels = {2, 1, 0.5, 0.25};
  options.own_step_voxels = {};
  options.own_sparse = {};
  options.repeats = {1, 0};
  options.of_device = false;
  options.vtk_gpu = options.vtk_fixed_point = false;
  CollectingDiagnostics diagnostics;
  const auto report = compare_renderers({small_scene(false)}, options, diagnostics);
  ASSERT_TRUE(test::has_value(report));
  // The rows alternate between two engines. The last row is that of the chosen step.
  ASSERT_EQ(report->rows.size(), 9U);
  for (std::size_t i = 2; i < 8; ++i) {
    EXPECT_LT(report->rows[i].rms, report->rows[i - 2].rms) << report->rows[i].engine;
  }
}

TEST(RenderComparisonTest, OnAGpuWallTimesAndFragmentShadersAreReported) {
  RenderBenchOptions options;
  options.step_voxels = {1, 0.5};
  options.own_step_voxels = {};
  options.own_sparse = {};
  options.repeats = {1, 0};
  options.of_device = true;
  options.vtk_gpu_half = options.vtk_fixed_point = false;
  CollectingDiagnostics diagnostics;
  const auto report = compare_renderers({small_scene(false)}, options, diagnostics);
  ASSERT_TRUE(test::has_value(report));
  std::vector<std::string> engines;
  for (const RenderBenchRow& row : report->rows) engines.push_back(row.engine);
  EXPECT_EQ(engines, (std::vector<std::string>{"cpu", "gl", "gl-fragment", "vtk-gpu", "cpu", "gl",
                                               "gl-fragment", "vtk-gpu"}));
  EXPECT_EQ(report->rows[1].rms, report->rows[2].rms);
  EXPECT_TRUE(report->chosen.empty());
  for (const char* engine : {"gl", "vtk-gpu"}) {
    std::vector<double> walls;
    for (const RenderBenchRow& row : report->rows) walls.push_back(row.wall_s);
    const ErrorCurve curve = curve_of(*report, "ball", {{engine}, false});
    for (const CurvePoint& point : curve.front())
      EXPECT_EQ(std::count(walls.begin(), walls.end(), point.time_s), 1) << engine;
  }
  EXPECT_NE(to_text(*report).find("gl-fragment_vs_vtk_gpu"), std::string::npos);
}

TEST(RenderComparisonTest, RejectsImageSizesWithOtherPixelCentres) {
  NamedScene named = small_scene(false);
  named.scene.width = 128;
  CollectingDiagnostics diagnostics;
  EXPECT_TRUE(test::rejects(compare_renderers({named}, {}, diagnostics), ErrorCode::kUsage,
                            {"scene ball", "odd multiple of 64 x 48", "128 x 144"}));
}

TEST(RenderComparisonTest, RejectsScenesThatVtkCannotDraw) {
  NamedScene named = small_scene(false);
  named.scene.spheres = test::test_spheres(named.scene.ct->grid());
  CollectingDiagnostics diagnostics;
  EXPECT_TRUE(test::rejects(compare_renderers({named}, {}, diagnostics), ErrorCode::kUsage,
                            {"scene ball", "CT alone"}));
}

TEST(GlPredicateBenchTest, MeasuresTheSameScenesOnAGpu) {
  auto neck = neck_phantom(32);
  ASSERT_TRUE(test::has_value(neck));
  neck->appearances.resize(1);
  for (const bool of_device : {false, true}) {
    CollectingDiagnostics diagnostics;
    int done = 0;
    const auto report = measure_gl_predicates(
        {*neck}, 64, 48, 1, diagnostics, [&] { ++done; }, of_device);
    ASSERT_TRUE(test::has_value(report));
    EXPECT_EQ(done, 1);
    ASSERT_EQ(report->rows.size(), 1U);
    EXPECT_EQ(report->width, of_device ? 64 : 32);
    const GlPredicateRow& row = report->rows[0];
    for (const double ms : {row.standard_ms, row.predicate_ms, row.brute_ms, row.paper_ms})
      EXPECT_GT(ms, 0);
    EXPECT_TRUE(row.identical);
    EXPECT_LE(row.max_error, 1.0 / 255);
    EXPECT_LE(row.paper_difference, 1.0 / 255);
    EXPECT_LE(row.paper_rms, row.paper_difference);
    EXPECT_GT(report->vs_paper_shader().value_or(0), 0);
    EXPECT_EQ(row.cpu_engine_ms.has_value(), !of_device);
    EXPECT_EQ(row.paper_own_filter_difference.has_value(), of_device);
    EXPECT_EQ(report->vs_paper_shader_own_filter().has_value(), of_device);
  }
}

TEST(GlPredicateBenchTest, DoesNotCompareTimesOfDifferentImages) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (const double rms : {1.01 * kSameImageRms, kNone}) {
    GlPredicateReport report;
    report.rows.resize(3);
    for (GlPredicateRow& row : report.rows) {
      row.standard_ms = row.predicate_ms = 1;
      row.paper_ms = 4;
      row.cpu_engine_ms = 2;
      row.paper_difference = 1;  // A single sample.
    }
    EXPECT_EQ(report.vs_paper_shader(), 4);
    EXPECT_EQ(report.cpu_vs_paper_shader(), 2);
    report.rows[1].paper_rms = rms;
    EXPECT_EQ(report.vs_paper_shader(), std::nullopt);
    EXPECT_EQ(report.cpu_vs_paper_shader(), std::nullopt);
    EXPECT_NE(to_text(report).find("not compared"), std::string::npos);
  }
}

TEST(PaperShaderTest, FragmentAndComputeShadersGiveTheSameImage) {
  const auto neck = neck_phantom(32);
  ASSERT_TRUE(test::has_value(neck));
  const auto scene = predicate_scene(*neck, neck->appearances.back().model, 40, 30);
  std::optional<render::RenderedImage> first;
  for (const auto& [compute, manual] :
       {std::pair{false, false}, {false, true}, {true, false}, {true, true}}) {
    const auto shader = make_paper_shader({.compute = compute, .manual_filter = manual});
    ASSERT_TRUE(test::has_value(shader));
    const auto image = (*shader)->render(scene);
    ASSERT_TRUE(test::has_value(image));
    if (!first) first = *image;
    // Fractions of 8 bits move single samples over the limit of a predicate.
    EXPECT_LT(rms_difference(*first, *image), kSameImageRms);
    if (!manual) {
      EXPECT_LT(largest_difference(*first, *image), 2e-5);
    }
  }
}

/// White where something is drawn on the black background.
Image2d<Rgba8> silhouette(const Image2d<Rgba8>& image) {
  std::vector<Rgba8> pixels;
  for (const Rgba8& p : image.pixels()) {
    constexpr int kDrawn255 = 30;
    const std::uint8_t white = p.r + p.g + p.b > kDrawn255 ? 255 : 0;
    pixels.push_back({white, white, white, 255});
  }
  return {image.width(), image.height(), std::move(pixels)};
}

TEST(VtkBaselineTest, DrawsAnObliqueVolumeAtItsPosition) {
  render::Scene scene = test::ball_scene(test::oblique_grid());
  scene.shading.enabled = false;
  const auto truth = render::make_reference_engine()->render(scene);
  ASSERT_TRUE(test::has_value(truth));
  for (const auto mapper : {VtkBaseline::Mapper::kGpu, VtkBaseline::Mapper::kFixedPoint}) {
    auto baseline = VtkBaseline::create(mapper, scene);
    ASSERT_TRUE(test::has_value(baseline));
    const auto found = (*baseline)->render(scene);
    test::keep_image("oblique_" + to_string(mapper), found);
    // Only the silhouettes are compared: edges differ by half a step, but a wrong position by far
    // more. Colours are not compared, because the fixed-point mapper brightens the whole ball by a
    // tenth in one of twenty runs.
    EXPECT_LT(test::difference(silhouette(found), silhouette(render::to_8bit(truth->pixels)), 1)
                  .fraction_above,
              0.02)
        << to_string(mapper);
  }
}

}  // namespace
}  // namespace nav::bench
