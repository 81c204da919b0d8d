// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <gtest/gtest.h>

#include "render/engine.hpp"
#include "tests/render/gl/gl_images.hpp"
#include "tests/render/gl/gl_random_scenes.hpp"
#include "tests/render/scene_support.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

/// One random scene per seed. The scenes differ in their elements.
class GlRandomTest : public testing::TestWithParam<unsigned> {
 protected:
  void SetUp() override {
    CollectingDiagnostics diagnostics;
    auto gl = make_gl_engine(diagnostics);
    ASSERT_TRUE(test::has_value(gl));
    gl_ = std::move(gl).value();
  }
  std::unique_ptr<Engine> gl_;
};

bool same_bits(const RenderedImage& a, const RenderedImage& b) {
  const auto x = a.pixels.pixels();
  const auto y = b.pixels.pixels();
  return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size_bytes()) == 0;
}

TEST_P(GlRandomTest, AgreesWithTheReferenceAndSkippingChangesNoBit) {
  Scene scene = test::RandomScenes(GetParam()).next();
  const auto skipped = gl_->render(scene);
  const auto expected = make_reference_engine()->render(scene);
  ASSERT_TRUE(test::has_value(skipped));
  ASSERT_TRUE(test::has_value(expected));
  const std::string name = "random" + std::to_string(GetParam());
  test::keep_image(name + "_gl", to_8bit(skipped->pixels));
  test::keep_image(name + "_reference", to_8bit(expected->pixels));
  EXPECT_TRUE(test::agree(skipped->pixels, expected->pixels, test::kAgreement255));
  scene.quality.skip_empty_bricks = false;
  const auto all = gl_->render(scene);
  ASSERT_TRUE(test::has_value(all));
  EXPECT_TRUE(same_bits(*all, *skipped));
  EXPECT_LE(skipped->statistics.volume_samples, all->statistics.volume_samples);
}

/// All seeds together test 1000 transfer functions and views.
TEST_P(GlRandomTest, SkippingChangesNoBitOfAnyView) {
  test::RandomScenes scenes(GetParam());
  Scene scene = scenes.next();
  constexpr int kViews = 25;
  std::size_t samples = 0;
  for (int view = 0; view < kViews; ++view) {
    scenes.vary(scene);
    scene.quality.skip_empty_bricks = true;
    const auto skipped = gl_->render(scene);
    scene.quality.skip_empty_bricks = false;
    const auto all = gl_->render(scene);
    ASSERT_TRUE(test::has_value(skipped));
    ASSERT_TRUE(test::has_value(all));
    EXPECT_TRUE(same_bits(*all, *skipped)) << "view " << view;
    EXPECT_LE(skipped->statistics.volume_samples, all->statistics.volume_samples);
    samples += skipped->statistics.volume_samples;
  }
  EXPECT_GT(samples, 0U) << "nothing was drawn";
}

/// The two single-precision engines differ by rounding. The difference is larger only if the last
/// bit decides the number of shaded points or the edge of a solid.
TEST(GlAndCpuTest, DifferOnlyByRounding) {
  constexpr float kRounding = 2e-5F;
  CollectingDiagnostics diagnostics;
  auto gl = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(gl));
  const auto cpu = make_cpu_engine();
  std::size_t pixels = 0;
  std::size_t beyond = 0;
  int whole_scenes = 0;
  constexpr unsigned kScenes = 40;
  for (unsigned seed = 0; seed < kScenes; ++seed) {
    const Scene scene = test::RandomScenes(seed).next();
    const auto a = (*gl)->render(scene);
    const auto b = cpu->render(scene);
    ASSERT_TRUE(test::has_value(a));
    ASSERT_TRUE(test::has_value(b));
    std::size_t here = 0;
    for (std::size_t i = 0; i < a->pixels.pixels().size(); ++i) {
      if (test::difference(a->pixels.pixels()[i], b->pixels.pixels()[i]) > kRounding) ++here;
    }
    pixels += a->pixels.pixels().size();
    beyond += here;
    if (here == 0) ++whole_scenes;
  }
  EXPECT_LT(static_cast<double>(beyond), 0.02 * static_cast<double>(pixels));
  EXPECT_GE(whole_scenes, 25);
}

/// Tests what an engine keeps between images, with different numbers of threads.
TEST(CpuEngineTest, AnEditedSceneEqualsThatOfANewEngine) {
  constexpr unsigned kSeeds = 25;
  constexpr int kEdits = 20;
  int drawn = 0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    test::RandomScenes scenes(seed);
    Scene scene = scenes.next();
    const auto kept = make_cpu_engine({1});
    for (int edit = 0; edit < kEdits; ++edit) {
      scenes.edit(scene);
      const auto a = kept->render(scene);
      const auto b = make_cpu_engine({2})->render(scene);
      ASSERT_TRUE(test::has_value(a));
      ASSERT_TRUE(test::has_value(b));
      EXPECT_TRUE(same_bits(*a, *b)) << "seed " << seed << ", edit " << edit;
      drawn += b->statistics.volume_samples > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(drawn, kSeeds * kEdits / 2);
}

INSTANTIATE_TEST_SUITE_P(Seeds, GlRandomTest, testing::Range(0U, 40U));

}  // namespace
}  // namespace nav::render
