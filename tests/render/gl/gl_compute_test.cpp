// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests the settings for devices other than software rasterisers: compute shaders, one cell at a
// time, and images that are read through the memory of the driver.

#include <algorithm>
#include <gtest/gtest.h>

#include "render/gl/gl_device.hpp"
#include "render/gl/gl_speed_probe.hpp"
#include "render/two_volumes.hpp"
#include "tests/render/gl/gl_images.hpp"
#include "tests/render/gl/gl_random_scenes.hpp"
#include "tests/render/gl/gl_view.hpp"
#include "tests/render/predicates/two_volume_scenes.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

class GlComputeTest : public test::GlViewTest {
 protected:
  struct Drawn {
    std::vector<RgbaF> pixels;
    RenderStatistics statistics;
  };
  Drawn drawn(const Scene& scene, bool compute) {
    caster().set_compute(compute);
    Drawn out;
    out.pixels = draw(scene);
    out.statistics = statistics();
    return out;
  }
  /// Largest difference of two images of one scene over all channels, [0, 1].
  static float largest_difference(const Drawn& a, const Drawn& b) {
    EXPECT_EQ(a.pixels.size(), b.pixels.size());
    float most = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
      most = std::max(most, static_cast<float>(test::difference(a.pixels[i], b.pixels[i])));
    return most;
  }
  /// Expects equal images without interpolated pixels, because compute shaders cast every ray.
  void expect_same(Scene scene, unsigned which) {
    constexpr float kRounding = 2e-5F;
    scene.quality.pixel_error = 0;
    const Drawn fragment = drawn(scene, false);
    EXPECT_FALSE(caster().computes());
    const Drawn compute = drawn(scene, true);
    EXPECT_TRUE(caster().computes());
    EXPECT_LE(largest_difference(fragment, compute), kRounding) << which;
    EXPECT_EQ(fragment.statistics.volume_samples, compute.statistics.volume_samples) << which;
    EXPECT_EQ(fragment.statistics.gradient_samples, compute.statistics.gradient_samples) << which;
    EXPECT_EQ(fragment.statistics.faded_cells, compute.statistics.faded_cells) << which;
    EXPECT_EQ(fragment.statistics.rays, compute.statistics.rays) << which;
  }
};

TEST_F(GlComputeTest, DrawsTheSameAsFragmentShaders) {
  for (unsigned seed = 0; seed < 10; ++seed) expect_same(test::RandomScenes(seed).next(), seed);
}

TEST_F(GlComputeTest, DrawsPredicatesAndTwoVolumesLikeFragmentShaders) {
  std::mt19937 random(3);
  for (int i = 0; i < 2; ++i) {
    const Scene both = test::random_two(random, i);
    const Scene alone = ultrasound_scene(both);
    caster().set_settled_after(1000 * i);  // Its own program first, then the generic one.
    expect_same(both, static_cast<unsigned>(i));
    expect_same(alone, static_cast<unsigned>(i));
  }
}

// Two volumes are excluded, see GlRaycaster::know_device().
TEST_F(GlComputeTest, TablesInStorageBuffersGiveEqualImages) {
  caster().set_compute(true);
  int programs = 0;
  const auto expect_same_of_storage = [&](const Scene& scene, const std::string& which) {
    caster().set_storage(false);
    const Image2d<RgbaF> textures(scene.width, scene.height, draw(scene));
    caster().set_storage(true);
    const int compiled = caster().compiled();
    const Image2d<RgbaF> storage(scene.width, scene.height, draw(scene));
    programs += caster().compiled() - compiled;
    EXPECT_EQ(test::difference(storage, textures, 0.01).fraction_above, 0) << which;
  };
  for (unsigned seed = 0; seed < 4; ++seed) {
    Scene scene = test::RandomScenes(seed).next();
    scene.quality.pixel_error = 0;
    expect_same_of_storage(scene, "seed " + std::to_string(seed));
    scene.quality.classification = Classification::kPostClassified;
    expect_same_of_storage(scene, "post-classified, seed " + std::to_string(seed));
  }
  std::mt19937 random(3);
  for (int i = 0; i < 2; ++i) {
    const Scene both = test::random_two(random, i);
    const Scene alone = ultrasound_scene(both);
    caster().set_settled_after(1000 * i);
    expect_same_of_storage(alone, "predicates " + std::to_string(i));
  }
  EXPECT_GT(programs, 2);
}

TEST_F(GlComputeTest, EditsGiveTheSameImageAsAFullRendering) {
  draw_anew(test::RandomScenes(0).next());  // Creates the second caster.
  caster().set_compute(true);
  other_->raycaster().set_compute(true);
  std::uint64_t rays = 0;
  std::uint64_t pixels = 0;
  for (unsigned seed = 0; seed < 2; ++seed) {
    test::RandomScenes scenes(seed);
    Scene scene = scenes.next();
    for (int edit = 0; edit < 10; ++edit) {
      scenes.edit(scene);
      const auto kept = draw(scene);
      rays += statistics().rays;
      pixels += kept.size();
      EXPECT_TRUE(test::same_bits(kept, draw_anew(scene))) << "seed " << seed << ", edit " << edit;
    }
  }
  EXPECT_GT(rays, 0U);
  EXPECT_LT(rays, pixels) << "rays that nothing moved keep what they show";
}

TEST_F(GlComputeTest, CastsARayForEveryPixel) {
  Scene scene = test::ball_scene(test::cube_grid(48, 2), 96, 72);
  const Drawn every = drawn(scene, true);
  scene.quality.pixel_error = 0.1;
  const Drawn spared = drawn(scene, false);
  EXPECT_GT(spared.statistics.pixels_without_ray, 0U);
  const Drawn none = drawn(scene, true);
  EXPECT_EQ(none.statistics.pixels_without_ray, 0U);
  EXPECT_TRUE(test::same_bits(none.pixels, every.pixels));
  EXPECT_TRUE(test::same_bits(drawn(scene, false).pixels, spared.pixels));
}

TEST_F(GlComputeTest, OneCellAtATimeGivesTheSameImage) {
  constexpr double kAgreement = 0.02;
  for (unsigned seed = 0; seed < 8; ++seed) {
    Scene scene = test::RandomScenes(seed).next();
    const auto at = [&](bool unrolled) {
      caster().set_unrolled(unrolled);
      return Image2d<RgbaF>(scene.width, scene.height, draw(scene));
    };
    const auto four = at(true);
    const std::uint64_t shades = statistics().gradient_samples;
    EXPECT_TRUE(test::agree(at(false), four, kAgreement)) << seed;
    EXPECT_NEAR(static_cast<double>(statistics().gradient_samples), static_cast<double>(shades),
                0.01 * static_cast<double>(shades))
        << seed;
  }
}

TEST_F(GlComputeTest, PredicatesOneCellAtATimeGiveTheSameImage) {
  constexpr double kAgreement = 0.02;
  std::mt19937 random(5);
  caster().set_settled_after(0);
  for (const bool cut : {false, true}) {
    Scene both = test::random_two(random, cut ? 1 : 0);
    if (cut) both.cutaway.emplace().around_spheres = true;
    both.spheres = {{both.ct->grid().centre(), 3}};
    const Scene alone = ultrasound_scene(both);
    for (const Scene& scene : {both, alone}) {
      const auto at = [&](bool unrolled) {
        caster().set_unrolled(unrolled);
        return Image2d<RgbaF>(scene.width, scene.height, draw(scene));
      };
      const auto two = at(true);
      const std::uint64_t samples = statistics().volume_samples;
      EXPECT_GT(samples, 0U);
      EXPECT_TRUE(test::agree(at(false), two, kAgreement)) << cut;
      EXPECT_NEAR(static_cast<double>(statistics().volume_samples), static_cast<double>(samples),
                  0.001 * static_cast<double>(samples));
    }
  }
}

TEST_F(GlComputeTest, ReadsAndTimesImagesWithoutChangingThem) {
  Scene scene = test::ball_scene(test::cube_grid(24, 2), 61, 47);
  scene.cutaway.emplace().around_spheres = true;
  scene.spheres = {{scene.ct->grid().centre(), 4}};
  scene.shading.enabled = true;
  caster().set_in_software(true);
  const auto direct = draw(scene);
  const RenderStatistics summed = statistics();
  EXPECT_GT(summed.volume_samples, 0U);
  EXPECT_GT(summed.gradient_samples, 0U);
  EXPECT_GT(summed.faded_cells, 0U);
  EXPECT_GT(summed.cutaway_rays, 0U);
  EXPECT_LT(summed.cutaway_rays, summed.rays);
  caster().set_in_software(false);
  EXPECT_TRUE(test::same_bits(caster().read(), direct));
  for (int time = 0; time < 2; ++time) {
    EXPECT_EQ(statistics().volume_samples, summed.volume_samples);
    EXPECT_EQ(statistics().gradient_samples, summed.gradient_samples);
    EXPECT_EQ(statistics().faded_cells, summed.faded_cells);
    EXPECT_EQ(statistics().rays, summed.rays);
    EXPECT_EQ(statistics().cutaway_rays, summed.cutaway_rays);
  }
  caster().forget_image();
  EXPECT_TRUE(test::same_bits(draw(scene), direct));
  EXPECT_GT(statistics().cast_s, 0);
  EXPECT_GE(statistics().prepare_s, 0);
  // More and fewer blocks than before.
  for (const int side : {150, 33}) {
    scene.width = scene.height = side;
    draw(scene);
    const RenderStatistics on_device = statistics();
    caster().set_in_software(true);
    EXPECT_EQ(on_device.volume_samples, statistics().volume_samples) << side;
    EXPECT_EQ(on_device.rays, statistics().rays) << side;
    caster().set_in_software(false);
  }
}

TEST_F(GlComputeTest, ADriverWithoutComputeShadersUsesFragmentShaders) {
  Scene scene = test::ball_scene(test::cube_grid(24, 2), 61, 47);
  const Drawn fragment = drawn(scene, false);
  caster().reject_compute();
  scene.quality.jitter = true;  // Needs another program.
  const Drawn jittered = drawn(scene, true);
  EXPECT_FALSE(caster().computes());
  EXPECT_GT(jittered.statistics.rays, 0U);
  scene.quality.jitter = false;
  EXPECT_TRUE(test::same_bits(draw(scene), fragment.pixels));
}

TEST_F(GlComputeTest, IsChosenByMeasurement) {
  window_->window().MakeCurrent();
  const bool faster = compute_is_faster();
  EXPECT_FALSE(faster && runs_in_software(window_->device())) << window_->device();
  EXPECT_EQ(compute_is_faster(), faster);
  draw(test::ball_scene(test::cube_grid(16, 2), 40, 30));
  EXPECT_EQ(caster().computes(), faster);
}

}  // namespace
}  // namespace nav::render
