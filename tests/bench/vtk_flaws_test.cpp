// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests the opacity of thin steps. Other renderers compute it incorrectly, and the tests show this
// on them and on the naive formulas. The engines of Sonde compute it correctly. If a test of the
// mappers fails with a new VTK, VTK has corrected the error: remove the test.
#include <cmath>
#include <gtest/gtest.h>

#include "bench/vtk_baseline.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::bench {
namespace {

constexpr double kLengthMm = 200;

/// A slab with one opacity per mm, 200 mm thick, seen from the front with one step length.
render::Scene slab(double opacity_per_mm, double step_voxels) {
  const auto ct = test::make_volume(test::centred_grid({9, 201, 9}, {4, 1, 4}),
                                    [](int, int, int) { return 0; });
  render::Scene scene =
      test::plain_scene(ct, test::fog(-std::log1p(-opacity_per_mm)), test::frontal(250, 10, true));
  scene.width = scene.height = 5;
  scene.quality.step_voxels = step_voxels;
  return scene;
}

double exact(double opacity_per_mm) { return -std::expm1(kLengthMm * std::log1p(-opacity_per_mm)); }

double drawn_by_vtk(VtkBaseline::Mapper mapper, const render::Scene& scene) {
  auto baseline = VtkBaseline::create(mapper, scene);
  EXPECT_TRUE(test::has_value(baseline));
  if (!baseline) return std::nan("");
  return (*baseline)->render(scene).at(2, 2).g / 255.0;
}

class VtkFlawsTest : public ::testing::TestWithParam<VtkBaseline::Mapper> {};
INSTANTIATE_TEST_SUITE_P(Mappers, VtkFlawsTest,
                         ::testing::Values(VtkBaseline::Mapper::kGpu,
                                           VtkBaseline::Mapper::kFixedPoint),
                         [](const auto& m) {
                           return m.param == VtkBaseline::Mapper::kGpu ? "gpu" : "fixedpoint";
                         });

TEST_P(VtkFlawsTest, OpacitiesOfATenThousandthAreUpToNineTimesTooLarge) {
  // VTK does not correct the opacity for the step for table entries <= 1e-4. Each of the ten
  // samples per mm has the opacity of one mm.
  for (const double opacity : {1e-4, 5e-5}) {
    const double found = drawn_by_vtk(GetParam(), slab(opacity, 0.1));
    EXPECT_GT(found, 5 * exact(opacity)) << "opacity of 1 mm " << opacity;
    EXPECT_LT(found, 15 * exact(opacity)) << "not this flaw";
  }
}

TEST_P(VtkFlawsTest, LargerOpacitiesAreCorrect) {
  // The scene is correct: for values without the error, VTK agrees with the closed form.
  constexpr double kTolerance = 0.02;  // 8 bits, and 15-bit fixed point of many thin samples.
  for (const double opacity : {1e-2, 3e-3}) {
    EXPECT_NEAR(drawn_by_vtk(GetParam(), slab(opacity, 0.5)), exact(opacity), kTolerance);
  }
}

/// The engines of Sonde. GL uses the OpenGL of this computer.
std::vector<std::unique_ptr<render::Engine>> engines(Diagnostics& diagnostics) {
  std::vector<std::unique_ptr<render::Engine>> all;
  all.push_back(render::make_reference_engine());
  all.push_back(render::make_cpu_engine());
  all.push_back(render::make_cpu_engine({0, render::CpuLanes::kPortable}));
  auto gl = render::make_gl_engine(diagnostics);
  EXPECT_TRUE(test::has_value(gl));
  if (gl) all.push_back(std::move(gl).value());
  return all;
}

TEST(ThinStepsTest, SondeIsExactForAllOpacitiesAndSteps) {
  constexpr double kTolerance = 1e-4;
  constexpr double kRelativeTolerance = 5e-3;  // Share of the smallest opacity, in single
                                               // precision.
  CollectingDiagnostics diagnostics;
  for (const auto& engine : engines(diagnostics)) {
    for (const double opacity : {1e-7, 1e-6, 1e-5, 5e-5, 1e-4, 1e-3, 1e-2, 0.3, 1 - 1e-9}) {
      for (const double step : {1.0 / 32, 0.1, 0.5, 1.0, 2.7, 8.0}) {
        const float found = test::middle(test::draw(*engine, slab(opacity, step))).g;
        EXPECT_NEAR(found, exact(opacity),
                    std::min(kTolerance, kRelativeTolerance * exact(opacity)))
            << engine->name() << ", opacity of 1 mm " << opacity << ", step " << step;
      }
    }
  }
}

// ---- The naive formulas in single precision ---------------------------------------------------

TEST(NaiveOpacityTest, PowerLosesTinyOpacities) {
  // 1 - (1 - a)^h with a = 1e-7 and h = 0.1: 1 - a is 1 or 1 - 1.2e-7.
  const auto power = [](float a, float h) { return 1.0F - std::pow(1.0F - a, h); };
  const auto ours = [](float a, float h) { return -std::expm1(std::log1p(-a) * h); };
  EXPECT_GT(std::abs(power(1e-7F, 0.1F) - 1e-8F), 0.5 * 1e-8F);
  EXPECT_GT(std::abs(power(1e-5F, 0.1F) - 1e-6F), 5e-3 * 1e-6F);
  EXPECT_NEAR(ours(1e-7F, 0.1F), 1e-8F, 1e-5 * 1e-8F);
  EXPECT_NEAR(ours(1e-5F, 0.1F), 1e-6F, 1e-5 * 1e-6F);
}

TEST(NaiveOpacityTest, FadingAfterTheStepDependsOnTheStep) {
  // Opacity 0.6 of 1 mm, half faded, over 1 mm: 0.3 for all steps if the fade comes first.
  for (const int steps : {1, 4, 64}) {
    const double h = 1.0 / steps;
    const double faded_first = 1 - std::pow(1 - 0.6 * 0.5, h);
    const double faded_last = (1 - std::pow(1 - 0.6, h)) * 0.5;
    EXPECT_NEAR(1 - std::pow(1 - faded_first, steps), 0.3, 1e-12);
    if (steps > 1) {
      EXPECT_GT(1 - std::pow(1 - faded_last, steps), 0.34);
    }
  }
}

}  // namespace
}  // namespace nav::bench
