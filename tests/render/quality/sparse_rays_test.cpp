// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests images with fewer rays than pixels: the rule, the pixels that always get a ray, and the
// saved work. Runs on each engine that has this feature.
#include "render/quality/sparse_rays.hpp"

#include <algorithm>
#include <cmath>

#include "tests/render/verification_engines.hpp"

namespace nav::render {
namespace {

/// Waves with a length of some voxels, so that means are close but not equal. A third of the volume
/// is empty.
std::shared_ptr<const StoredVolume> waves(double spacing_mm) {
  return test::make_volume(test::centred_grid({40, 36, 44}, Eigen::Vector3d::Constant(spacing_mm)),
                           [](int i, int j, int k) {
                             if (i > 26) return -1000.0;
                             return 300 * std::sin(0.5 * i) * std::cos(0.35 * k) +
                                    120 * std::sin(0.4 * j);
                           });
}

TransferFunction ramp() {
  return *TransferFunction::create(
      "ramp",
      {{-900, {0, 0, 0}, 0, 1}, {-300, {0.2, 0.4, 1}, 0.02, 1}, {300, {1, 0.7, 0.3}, 0.1, 1}});
}

/// pixels_per_voxel: the value in the middle of the volume.
Scene wavy(double pixels_per_voxel, bool orthographic) {
  const double height_mm = 60;
  const int height = static_cast<int>(std::lround(height_mm * pixels_per_voxel));
  Scene scene = test::plain_scene(waves(1), ramp(), test::frontal(250, height_mm, orthographic));
  scene.height = height + 1;  // So that some pixels lie outside the lattice.
  scene.width = height + 3;
  scene.quality.opaque_at = 0.996;
  return scene;
}

Scene with_plane_and_shapes(Scene scene) {
  scene.plane = test::upright_plane(test::grey_image(30, 30, 100), 1, {-15, 3, 15});
  scene.needle = test::needle({-8, -14, -5}, {12, -16, 20});
  scene.spheres.push_back({{{5, -15, 5}}, 2.5});
  scene.lines.push_back({{{-20, -15, -20}}, {{20, -15, -10}}});
  return scene;
}

/// The engines with this feature. The reference and compute shaders cast all rays.
std::vector<test::EngineCase> engines_with_it() {
  std::vector<test::EngineCase> cases = test::verified_engines();
  std::erase_if(cases, [](const auto& one) {
    const std::string name = one.name;
    return name == "reference" || name == "gl_compute";
  });
  return cases;
}

using SparseRaysTest = test::VerificationTest;
INSTANTIATE_TEST_SUITE_P(Engines, SparseRaysTest, ::testing::ValuesIn(engines_with_it()),
                         [](const auto& c) { return c.param.name; });

TEST(SparseRaysRuleTest, TheLatticeIsNeverWiderThanTwoVoxels) {
  for (const bool orthographic : {false, true}) {
    Scene scene = wavy(1.1, orthographic);
    EXPECT_FALSE(sparse_rays(scene)) << "nothing asked for";
    scene.quality.pixel_error = 0.1;
    ASSERT_TRUE(sparse_rays(scene));
    EXPECT_EQ(sparse_rays(scene)->stride, 2);
    Scene close = wavy(2.2, orthographic);
    close.quality.pixel_error = 0.1;
    EXPECT_EQ(sparse_rays(close)->stride, 4);
    Scene far = wavy(0.9, orthographic);
    far.quality.pixel_error = 0.1;
    EXPECT_FALSE(sparse_rays(far)) << "a voxel is smaller than a pixel";
    close.quality.jitter = true;
    EXPECT_FALSE(sparse_rays(close));
  }
}

TEST(SparseRaysRuleTest, RejectsInvalidErrors) {
  Scene scene = wavy(2.2, false);
  for (const double error : {-0.1, 1.1, std::nan("")}) {
    scene.quality.pixel_error = error;
    EXPECT_TRUE(test::rejects(validate(scene), ErrorCode::kMalformedData, {"quality.pixel_error"}));
  }
}

TEST_P(SparseRaysTest, EachPixelHasARayOrIsAMeanOfRaysThatAgree) {
  for (const bool orthographic : {false, true}) {
    for (const double pixels_per_voxel : {1.3, 2.6}) {
      Scene scene = wavy(pixels_per_voxel, orthographic);
      const RenderedImage dense = test::draw(*engine_, scene);
      double before = 0;
      for (const double error : {0.01, 0.05, 0.2}) {
        scene.quality.pixel_error = error;
        const RenderedImage sparse = test::draw(*engine_, scene);
        const auto pixels =
            static_cast<std::uint64_t>(scene.width) * static_cast<std::uint64_t>(scene.height);
        EXPECT_LE(sparse.statistics.rays + sparse.statistics.pixels_without_ray, pixels);
        const double spared = static_cast<double>(sparse.statistics.pixels_without_ray);
        EXPECT_GT(spared, before);
        before = spared;
        // Rays that lie apart visit bricks at other positions, which takes a few more samples.
        EXPECT_LE(static_cast<double>(sparse.statistics.volume_samples),
                  1.01 * static_cast<double>(dense.statistics.volume_samples));
        // No part of the waves is narrower than the lattice.
        EXPECT_LT(test::max_difference(sparse, dense), error);
        int equal = 0;
        for (std::size_t i = 0; i < pixels; ++i) {
          const float off = test::difference(sparse.pixels.pixels()[i], dense.pixels.pixels()[i]);
          equal += off < 1e-6 ? 1 : 0;
        }
        EXPECT_GE(equal, static_cast<int>(pixels - sparse.statistics.pixels_without_ray));
      }
    }
  }
}

TEST_P(SparseRaysTest, LargeErrorsAndSmallImagesDraw) {
  for (const int width : {1, 2, 3, 5, 8, 33}) {
    for (const int height : {1, 2, 4, 5, 31}) {
      Scene scene = with_plane_and_shapes(wavy(2.6, false));
      scene.width = width;
      scene.height = height;
      scene.camera.vertical_fov_rad *= height / 160.0;
      const RenderedImage dense = test::draw(*engine_, scene);
      scene.quality.pixel_error = 1e-9;
      EXPECT_LT(test::max_difference(test::draw(*engine_, scene), dense), 1e-6) << width << height;
      scene.quality.pixel_error = 1;
      (void)test::draw(*engine_, scene);
    }
  }
}

TEST_P(SparseRaysTest, SkippingChangesNoBit) {
  Scene scene = with_plane_and_shapes(wavy(2.6, false));
  scene.quality.pixel_error = 0.08;
  const RenderedImage with = test::draw(*engine_, scene);
  EXPECT_GT(with.statistics.pixels_without_ray, 1000U);
  scene.quality.skip_empty_bricks = false;
  EXPECT_TRUE(test::same_bytes(test::draw(*engine_, scene), with));
}

// A needle is narrower than the lattice, and all shapes have sharp outlines.
TEST_P(SparseRaysTest, ShapesAndTheOutlineOfTheUltrasoundImageKeepTheirRays) {
  Scene scene = with_plane_and_shapes(wavy(2.6, false));
  scene.transfer = test::fog(1e-9);
  for (const double opacity : {1.0, 0.5, 0.0}) {  // 0: stale, only a border.
    if (opacity > 0) scene.plane->opacity = opacity;
    if (!(opacity > 0)) scene.plane->safety = {SafetyState::kStale, "test"};
    scene.quality.pixel_error = 0;
    const RenderedImage dense = test::draw(*engine_, scene);
    scene.quality.pixel_error = 0.02;
    const RenderedImage sparse = test::draw(*engine_, scene);
    EXPECT_GT(sparse.statistics.pixels_without_ray, 1000U);
    EXPECT_LT(test::max_difference(sparse, dense), 2e-3);
  }
}

// The engine inserts the pixels of the image after it takes the means. Stripes of single pixels do
// not change.
TEST_P(SparseRaysTest, TheUltrasoundImageStaysSharp) {
  std::vector<std::uint8_t> stripes;
  for (int i = 0; i < 120 * 120; ++i) stripes.push_back(i % 120 % 2 == 0 ? 40 : 220);
  Scene scene = wavy(2.6, false);
  scene.plane =
      test::upright_plane(Image2d<std::uint8_t>(120, 120, std::move(stripes)), 0.25, {-15, 3, 15});
  scene.transfer = test::fog(1e-9);
  const RenderedImage dense = test::draw(*engine_, scene);
  scene.quality.pixel_error = 0.02;
  const RenderedImage sparse = test::draw(*engine_, scene);
  EXPECT_GT(sparse.statistics.pixels_without_ray, 1000U);
  EXPECT_LT(test::max_difference(sparse, dense), 0.02);
}

TEST_P(SparseRaysTest, MovedObjectsLeaveNoTrace) {
  Scene scene = with_plane_and_shapes(wavy(2.6, false));
  scene.quality.pixel_error = 0.08;
  const auto anew = [&] { return test::draw(*GetParam().make(), scene); };
  (void)test::draw(*engine_, scene);
  scene.needle = test::needle({-2, -14, -5}, {18, -16, 20});
  EXPECT_TRUE(test::same_bytes(test::draw(*engine_, scene), anew()));
  scene.plane->ct_from_image =
      test::upright_plane(test::grey_image(30, 30, 100), 1, {-9, 1, 12}).ct_from_image;
  EXPECT_TRUE(test::same_bytes(test::draw(*engine_, scene), anew()));
  scene.needle.reset();
  scene.spheres.clear();
  EXPECT_TRUE(test::same_bytes(test::draw(*engine_, scene), anew()));
  scene.plane->frame.pixels = test::grey_image(30, 30, 200);
  const RenderedImage live = test::draw(*engine_, scene);
  EXPECT_EQ(live.statistics.volume_samples, 0U);
  EXPECT_TRUE(test::same_bytes(live, anew()));
  scene.plane.reset();
  EXPECT_TRUE(test::same_bytes(test::draw(*engine_, scene), anew()));
  scene.quality.pixel_error = 0;
  EXPECT_TRUE(test::same_bytes(test::draw(*engine_, scene), anew()));
}

/// The share of pixels that differ by more than \p most. Sharp edges bend between the rays of the
/// lattice.
double share_beyond(const RenderedImage& a, const RenderedImage& b, double most) {
  const auto pixels = a.pixels.pixels();
  double count = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    count += test::difference(pixels[i], b.pixels.pixels()[i]) > most ? 1 : 0;
  }
  return count / static_cast<double>(pixels.size());
}

TEST_P(SparseRaysTest, CutawayProjectionsAndShadingAlsoUseFewerRays) {
  Scene scene = with_plane_and_shapes(wavy(2.6, true));
  scene.shading.enabled = true;
  scene.cutaway.emplace();
  const RenderedImage dense = test::draw(*engine_, scene);
  scene.quality.pixel_error = 0.05;
  const RenderedImage sparse = test::draw(*engine_, scene);
  EXPECT_GT(sparse.statistics.pixels_without_ray, 1000U);
  EXPECT_LT(share_beyond(sparse, dense, 0.05), 2e-3);
  scene.projection = Projection::kMaximum;
  const RenderedImage maximum = test::draw(*engine_, scene);
  EXPECT_GT(maximum.statistics.pixels_without_ray, 1000U);
  scene.quality.pixel_error = 0;
  EXPECT_LT(share_beyond(test::draw(*engine_, scene), maximum, 0.05), 2e-3);
}

}  // namespace
}  // namespace nav::render
