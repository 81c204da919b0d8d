// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <gtest/gtest.h>

#include "render/engine.hpp"
#include "tests/render/gl/gl_pictures.hpp"
#include "tests/render/gl/gl_random_scenes.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

// Requirement of the renderer: no visible difference from the double-precision reference.
constexpr double kAgreement255 = 2.0;

/// A scene of every seed, each with other features.
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

TEST_P(GlRandomTest, AgreesWithReferenceAndSkippingChangesNoBit) {
  Scene scene = test::RandomScenes(GetParam()).next();
  const auto skipped = gl_->render(scene);
  const auto expected = make_reference_engine()->render(scene);
  ASSERT_TRUE(test::has_value(skipped));
  ASSERT_TRUE(test::has_value(expected));
  const std::string name = "random" + std::to_string(GetParam());
  test::keep_picture(name + "_gl", to_8bit(skipped->pixels));
  test::keep_picture(name + "_reference", to_8bit(expected->pixels));
  EXPECT_TRUE(test::agree(skipped->pixels, expected->pixels, kAgreement255));
  scene.quality.skip_empty_bricks = false;
  const auto all = gl_->render(scene);
  ASSERT_TRUE(test::has_value(all));
  const auto a = all->pixels.pixels();
  const auto b = skipped->pixels.pixels();
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size_bytes()), 0);
  EXPECT_LE(skipped->statistics.volume_samples, all->statistics.volume_samples);
}

INSTANTIATE_TEST_SUITE_P(Seeds, GlRandomTest, testing::Range(0U, 40U));

}  // namespace
}  // namespace nav::render
