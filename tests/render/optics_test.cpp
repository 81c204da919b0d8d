// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compares opacity and colour with closed forms of the volume rendering integral.
#include "tests/render/verification_engines.hpp"

namespace nav::render {
namespace {

using OpticsTest = test::VerificationTest;
INSTANTIATE_TEST_SUITE_P(Engines, OpticsTest, ::testing::ValuesIn(test::verified_engines()),
                         [](const auto& c) { return c.param.name; });

/// A volume of 9 × n × 9 voxels with one value, seen along j.
std::shared_ptr<const StoredVolume> slab(int n, double spacing_mm) {
  return test::make_volume(test::centred_grid({9, n, 9}, {4, spacing_mm, 4}),
                           [](int, int, int) { return 0; });
}

TEST_P(OpticsTest, ASlabFollowsBeerLambertForAnyStep) {
  constexpr double kTolerance = 1e-5;  // Error of the opacity: single precision over 6400 cells.
  constexpr double kRelativeTolerance = 2e-3;  // For opacities below the absolute tolerance.
  const auto ct = slab(101, 2.0);              // The slab is 200 mm thick.
  for (const double opacity : {1e-7, 1e-5, 1e-4, 1e-2, 0.3, 1 - 1e-9}) {
    const double tau = -std::log1p(-opacity);
    const double expected = -std::expm1(-tau * 200);
    for (const double step : {1.0 / 32, 0.37, 0.5, 1.0, 3.3, 8.0}) {
      Scene scene = test::plain_scene(ct, test::fog(tau), test::frontal(313.7, 20, true));
      scene.width = scene.height = 3;
      scene.quality.step_voxels = step;
      const float found = test::middle(test::draw(*engine_, scene)).g;
      EXPECT_NEAR(found, expected, std::min(kTolerance, kRelativeTolerance * expected))
          << "opacity of 1 mm " << opacity << ", step " << step;
    }
  }
}

TEST_P(OpticsTest, OpacitiesTooSmallForSinglePrecisionAreInvisible) {
  const auto ct = slab(101, 2.0);
  for (const double tau : {1e-30, 1e-38, 1e-42, 1e-45, 1e-300, 5e-324}) {
    for (const double step : {1.0 / 32, 1.0, 8.0}) {
      Scene scene = test::plain_scene(ct, test::fog(tau), test::frontal(313.7, 20, true));
      scene.width = scene.height = 3;
      scene.background_rgb = {0.25, 0.5, 0.75};
      scene.quality.step_voxels = step;
      for (const bool shaded : {false, true}) {
        scene.shading.enabled = shaded;
        const RgbaF found = test::middle(test::draw(*engine_, scene));
        EXPECT_FLOAT_EQ(found.r, 0.25F) << tau << ", step " << step;
        EXPECT_FLOAT_EQ(found.g, 0.5F) << tau << ", step " << step;
        EXPECT_FLOAT_EQ(found.b, 0.75F) << tau << ", step " << step;
      }
    }
  }
}

TEST_P(OpticsTest, CutsTheCellAtAnOpaqueSurfaceExactly) {
  // Fog in front of a black plane, inside a cell of 8 voxels.
  constexpr double kTolerance = 1e-5;
  const auto ct = slab(41, 1.0);  // y is in [-20, 20].
  for (const double depth : {-19.9, -7.3, 0.0, 12.345, 19.99}) {
    Scene scene = test::plain_scene(ct, test::fog(0.05), test::frontal(100, 10, true));
    scene.quality.step_voxels = 8;
    scene.plane = test::upright_plane(test::grey_image(40, 40, 0), 1, {0, depth, 20});
    const float found = test::middle(test::draw(*engine_, scene)).g;
    EXPECT_NEAR(found, -std::expm1(-0.05 * (depth + 20)), kTolerance) << depth;
  }
}

TEST_P(OpticsTest, ATranslucentSurfaceDividesTheFog) {
  constexpr double kTolerance = 1e-5;
  const auto ct = slab(41, 1.0);
  Scene scene = test::plain_scene(ct, test::fog(0.02, {1, 0, 0}), test::frontal(100, 10, true));
  scene.quality.step_voxels = 4;
  scene.plane = test::upright_plane(test::grey_image(40, 40, 255), 1, {0, 5.5, 20});
  scene.plane->opacity = 0.25;
  scene.background_rgb = {0, 0, 1};
  const RgbaF found = test::middle(test::draw(*engine_, scene));
  const double front = std::exp(-0.02 * 25.5);
  const double back = std::exp(-0.02 * 14.5);
  EXPECT_NEAR(found.r, (1 - front) + front * (0.25 + 0.75 * (1 - back)), kTolerance);
  EXPECT_NEAR(found.g, front * 0.25, kTolerance);
  EXPECT_NEAR(found.b, front * (0.25 + 0.75 * back), kTolerance);
}

/// Error of the colour of a slab whose colour grows linearly with depth. The closed form is ∫ tau
/// e^(-tau s) s/L ds = (1 - e^(-x) (1 + x)) / x with x = tau L.
double ramp_error(Engine& engine, double step) {
  constexpr double kLengthMm = 64;
  constexpr double kTau = 0.04;
  const auto ct = test::make_volume(test::centred_grid({9, 65, 9}, {4, 1, 4}),
                                    [](int, int j, int) { return 10.0 * j; });
  const double opacity = -std::expm1(-kTau);
  const auto transfer =
      TransferFunction::create("ramp", {{0, {0, 0, 0}, opacity, 1}, {640, {1, 1, 1}, opacity, 1}});
  // The distance from the eye to the face is a whole number of cells, so every cell is whole.
  Scene scene = test::plain_scene(ct, *transfer, test::frontal(96, 10, true));
  scene.width = scene.height = 1;
  scene.quality.step_voxels = step;
  const double x = kTau * kLengthMm;
  return test::middle(test::draw(engine, scene)).g - (1 - std::exp(-x) * (1 + x)) / x;
}

TEST_P(OpticsTest, ConvergesWithSecondOrder) {
  constexpr double kRatioTolerance = 0.15;  // Effect of higher orders at large steps.
  const double e8 = ramp_error(*engine_, 8);
  const double e4 = ramp_error(*engine_, 4);
  const double e2 = ramp_error(*engine_, 2);
  EXPECT_GT(std::abs(e2), 1e-5) << "the error must stand out from single precision";
  EXPECT_NEAR(e8 / e4, 4, 4 * kRatioTolerance);
  EXPECT_NEAR(e4 / e2, 4, 4 * kRatioTolerance);
}

TEST_P(OpticsTest, AFogRampConvergesToItsIntegral) {
  // The extinction grows linearly with depth from 0 to 0.03 per mm over 64 mm. The rays are
  // oblique, so cells are cut anywhere.
  constexpr double kTolerance = 2e-4;
  const auto ct = test::make_volume(test::centred_grid({65, 65, 65}, {1, 1, 1}),
                                    [](int, int j, int) { return 10.0 * j; });
  const auto transfer = TransferFunction::create(
      "ramp", {{0, {1, 1, 1}, 0, 1}, {640, {1, 1, 1}, -std::expm1(-0.03), 1}});
  Scene scene = test::plain_scene(ct, *transfer, test::frontal(150, 10, true));
  scene.camera.eye_ct.mm.x() = 30;  // tan = 0.2.
  scene.quality.step_voxels = 0.25;
  const double along = std::hypot(1.0, 0.2) * 64;
  const float found = test::middle(test::draw(*engine_, scene)).g;
  EXPECT_NEAR(found, -std::expm1(-0.5 * 0.03 * along), kTolerance);
}

TEST_P(OpticsTest, TheHeadlightFollowsTheCosine) {
  // A ramp along x + y seen along y. The normal is at 45 degrees everywhere, and 100 HU/mm are
  // fully shaded.
  constexpr double kTolerance = 2e-3;  // Values are rounded to whole HU.
  const double slope = 100 / std::sqrt(2.0);
  const auto ct = test::make_volume(test::centred_grid({33, 33, 9}, {1, 1, 4}),
                                    [&](int i, int j, int) { return slope * (i + j - 32); });
  Scene scene = test::plain_scene(ct, test::fog(5, {0.5, 0.4, 0.3}), test::frontal(100, 4, true));
  scene.shading.enabled = true;
  scene.shading.ambient = 0.2;
  scene.shading.diffuse = 0.6;
  scene.shading.specular = 0.3;
  scene.shading.shininess = 10;
  scene.camera.eye_ct.mm.y() = -8;  // Inside the volume, because at its faces the gradient is
                                    // one-sided.
  const RgbaF found = test::middle(test::draw(*engine_, scene));
  const double c = std::sqrt(0.5);
  const double gloss = 0.3 * std::pow(c, 10);
  EXPECT_NEAR(found.r, 0.5 * (0.2 + 0.6 * c) + gloss, kTolerance);
  EXPECT_NEAR(found.b, 0.3 * (0.2 + 0.6 * c) + gloss, kTolerance);
}

TEST_P(OpticsTest, ConstantTissueStaysUnshaded) {
  Scene scene =
      test::plain_scene(slab(41, 1.0), test::fog(5, {0.5, 0.4, 0.3}), test::frontal(100, 4, true));
  scene.shading.enabled = true;
  scene.shading.ambient = 0.2;
  scene.shading.diffuse = 0.6;
  scene.shading.specular = 0.3;
  scene.shading.shininess = 10;
  EXPECT_NEAR(test::middle(test::draw(*engine_, scene)).r, 0.5, 1e-5);
}

TEST_P(OpticsTest, ShadingOfUnimportantTissueIsOmitted) {
  const auto ct = test::make_volume(test::centred_grid({17, 17, 17}, {1, 1, 1}),
                                    [](int i, int j, int k) { return 7 * i * j - 40 * k; });
  Scene scene = test::plain_scene(ct, test::fog(0.3), test::frontal(100, 20, true));
  scene.transfer = *TransferFunction::create(
      "unimportant", {{-700, {0.2, 0.3, 0.4}, 0, 0}, {1900, {0.9, 0.5, 0.1}, 0.8, 0}});
  const RenderedImage plain = test::draw(*engine_, scene);
  scene.shading.enabled = true;
  scene.shading.emphasis = 1;
  const RenderedImage shaded = test::draw(*engine_, scene);
  EXPECT_TRUE(test::same_bytes(plain, shaded));
  EXPECT_EQ(shaded.statistics.gradient_samples, 0U);
  EXPECT_EQ(shaded.statistics.volume_samples, plain.statistics.volume_samples);
  scene.transfer = *TransferFunction::create(
      "important at its end", {{-700, {0.2, 0.3, 0.4}, 0, 0}, {1900, {0.9, 0.5, 0.1}, 0.8, 0.5}});
  EXPECT_GT(test::draw(*engine_, scene).statistics.gradient_samples, 0U);
}

TEST_P(OpticsTest, EarlyTerminationStaysWithinItsBound) {
  const auto ct =
      test::make_volume(test::centred_grid({33, 33, 33}, {1, 1, 1}),
                        [](int i, int j, int k) { return 20 * ((i + 2 * j + k) % 17); });
  const auto transfer = TransferFunction::create(
      "tissue", {{0, {1, 0, 0}, 0.01, 1}, {200, {0, 1, 0}, 0.2, 1}, {320, {0, 0, 1}, 0.05, 1}});
  Scene scene = test::plain_scene(ct, *transfer, test::frontal(80, 40, false));
  scene.background_rgb = {1, 1, 1};
  const RenderedImage full = test::draw(*engine_, scene);
  for (const double opaque_at : {0.5, 0.9, 0.996}) {
    scene.quality.opaque_at = opaque_at;
    const RenderedImage early = test::draw(*engine_, scene);
    EXPECT_LE(test::max_difference(full, early), 1 - opaque_at + 1e-6);
    if (engine_->name() != "reference" && opaque_at < 0.6) {
      EXPECT_LT(early.statistics.volume_samples, full.statistics.volume_samples);
    }
  }
}

TEST_P(OpticsTest, ARayThatEndsEarlyShowsNoBackground) {
  Scene scene =
      test::plain_scene(slab(41, 1.0), test::fog(5, {0.5, 0.4, 0.3}), test::frontal(100, 4, true));
  scene.background_rgb = {0, 1, 0};
  scene.quality.opaque_at = 0.9;
  const RgbaF found = test::middle(test::draw(*engine_, scene));
  EXPECT_NEAR(found.r, 0.5, 1e-5);
  EXPECT_NEAR(found.g, 0.4, 1e-5);
  EXPECT_NEAR(found.b, 0.3, 1e-5);
  // White fog behind a white image is white, wherever the ray ends.
  scene.transfer = test::fog(5, {1, 1, 1});
  scene.plane = test::upright_plane(test::grey_image(20, 20, 255), 1, {0, -30, 10});
  scene.plane->opacity = 0.6;
  const RgbaF white = test::middle(test::draw(*engine_, scene));
  EXPECT_NEAR(white.r, 1, 1e-5);
  EXPECT_NEAR(white.b, 1, 1e-5);
}

TEST_P(OpticsTest, CountsRaysAndSamples) {
  Scene scene = test::plain_scene(slab(33, 1.0), test::fog(0.01), test::frontal(64, 10, true));
  scene.quality.step_voxels = 0.5;
  const RenderedImage plain = test::draw(*engine_, scene);
  const std::uint64_t rays = 33 * 25;
  EXPECT_EQ(plain.statistics.rays, rays);
  // The ends of 64 cells of 0.5 mm. OpenGL samples the points between two bricks twice.
  const std::uint64_t twice = engine_->name() == "gl" ? 4 : 0;
  EXPECT_EQ(plain.statistics.volume_samples, rays * (65 + twice));
  EXPECT_EQ(plain.statistics.gradient_samples, 0U);
  scene.quality.classification = Classification::kPostClassified;
  EXPECT_EQ(test::draw(*engine_, scene).statistics.volume_samples, rays * 64);
  scene.shading.enabled = true;
  EXPECT_EQ(test::draw(*engine_, scene).statistics.gradient_samples, rays * 64);
  scene.transfer = test::fog(0);
  const RenderedImage empty = test::draw(*engine_, scene);
  EXPECT_EQ(empty.statistics.gradient_samples, 0U);
  if (engine_->name() != "reference") {
    EXPECT_EQ(empty.statistics.volume_samples, 0U);
    EXPECT_EQ(empty.statistics.bricks, 2U * 5U * 2U);
    EXPECT_EQ(empty.statistics.bricks_occupied, 0U);
  }
}

}  // namespace
}  // namespace nav::render
