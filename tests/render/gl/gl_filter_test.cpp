// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests how shaders interpolate between the voxels of textures: GlFilter.

#include <gtest/gtest.h>

#include "render/gl/gl_device.hpp"
#include "render/two_volumes.hpp"
#include "tests/render/gl/gl_images.hpp"
#include "tests/render/gl/gl_random_scenes.hpp"
#include "tests/render/gl/gl_view.hpp"
#include "tests/render/predicates/two_volume_scenes.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

class GlFilterTest : public test::GlViewTest {
 protected:
  void SetUp() override {
    test::GlViewTest::SetUp();
    if (!HasFatalFailure()) caster().set_voxel_pairs(false);
  }
  Image2d<RgbaF> drawn(const Scene& scene, GlFilter filter) {
    caster().set_filter(filter);
    Image2d<RgbaF> image(scene.width, scene.height, draw(scene));
    EXPECT_EQ(caster().gathers(), filter == GlFilter::kGathers);
    return image;
  }
  /// Both filters interpolate in the shader, by the same formula.
  void expect_same(const Scene& scene, const std::string& which) {
    constexpr double kRounding255 = 0.01;
    const Image2d<RgbaF> fetched = drawn(scene, GlFilter::kFetches);
    EXPECT_GT(statistics().volume_samples, 0U) << which;
    EXPECT_TRUE(test::agree(drawn(scene, GlFilter::kGathers), fetched, kRounding255)) << which;
  }
};

TEST_F(GlFilterTest, IsChosenByMeasurement) {
  draw(test::ball_scene(test::cube_grid(16, 2), 40, 30));
  // The software rasteriser of Mesa interpolates in single precision.
  if (window_->device().find("llvmpipe") == std::string::npos) {
    GTEST_SKIP() << "only llvmpipe's filter is known, this is " << window_->device();
  }
  EXPECT_FALSE(caster().manual_filter());
  EXPECT_FALSE(caster().gathers());
}

TEST_F(GlFilterTest, EveryFilterGivesTheSameImage) {
  const Scene scene = test::ball_scene(test::oblique_grid());
  const Image2d<RgbaF> by_device = drawn(scene, GlFilter::kDevice);
  for (const GlFilter filter : {GlFilter::kFetches, GlFilter::kGathers})
    EXPECT_TRUE(test::agree(drawn(scene, filter), by_device, 0.5));
  EXPECT_EQ(caster().compiled(), 3);
  EXPECT_EQ(caster().uploads().volumes, 2) << "again as slices, and only then";
}

TEST_F(GlFilterTest, GathersGiveTheSameImageAsFetches) {
  for (unsigned seed = 0; seed < 4; ++seed)
    expect_same(test::RandomScenes(seed).next(), "seed " + std::to_string(seed));
}

TEST_F(GlFilterTest, GathersDrawPredicatesAndTwoVolumesLikeFetches) {
  std::mt19937 random(3);
  for (int i = 0; i < 2; ++i) {
    const Scene both = test::random_two(random, i);
    const Scene alone = ultrasound_scene(both);
    caster().set_settled_after(1000 * i);  // Its own program first, then the generic one.
    expect_same(both, "both " + std::to_string(i));
    expect_same(alone, "alone " + std::to_string(i));
  }
}

TEST_F(GlFilterTest, GathersReachTheLastVoxelOfEveryAxis) {
  for (const std::array<int, 3>& size :
       {std::array{1, 9, 8}, {9, 1, 8}, {8, 9, 1}, {1, 1, 9}, {2, 2, 2}, {1, 1, 1}, {9, 8, 7}}) {
    Scene scene = test::plain_scene(
        test::make_volume(test::centred_grid(size, {4, 5, 6}),
                          [](int i, int j, int k) { return 100 * i - 70 * j + 50 * k + 40; }),
        test::fog(0.01), test::frontal(150, 60, true));
    scene.projection = Projection::kMaximum;
    scene.grey = {200, 1600};
    expect_same(scene, std::to_string(size[0]) + ' ' + std::to_string(size[1]) + ' ' +
                           std::to_string(size[2]));
  }
}

TEST_F(GlFilterTest, VolumesWithTooManySlicesAreFetched) {
  Scene scene = test::ball_scene(test::cube_grid(24, 2), 60, 45);
  const Image2d<RgbaF> gathered = drawn(scene, GlFilter::kGathers);
  caster().set_most_slices(23);
  caster().set_filter(GlFilter::kGathers);
  const Image2d<RgbaF> fetched(60, 45, draw(scene));
  EXPECT_FALSE(caster().gathers());
  EXPECT_TRUE(test::agree(fetched, gathered, 0.01));
  scene.ct = test::ball_phantom(test::cube_grid(20, 2));
  draw(scene);
  EXPECT_TRUE(caster().gathers());
}

}  // namespace
}  // namespace nav::render
