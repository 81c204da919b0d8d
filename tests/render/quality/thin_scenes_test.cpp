// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/quality/thin_scenes.hpp"

#include <gtest/gtest.h>
#include <random>

#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

/// Linear, so that the mean around a voxel is its own value.
double value_at(int i, int j, int k) { return 40 * i + 30 * j - 17 * k; }

TEST(ThinScenesTest, EveryVoxelThatStaysKeepsItsPositionAndItsValue) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  for (const std::array<int, 3>& size :
       {std::array{16, 17, 40}, std::array{15, 16, 1}, std::array{31, 2, 33}}) {
    const auto whole = test::make_volume(test::centred_grid(size, {0.7, 0.8, 1.5}, turn), value_at);
    const auto thin = every_second_voxel(*whole);
    EXPECT_EQ(thin->name(), whole->name());
    std::array<int, 3> stride{};
    for (std::size_t a = 0; a < 3; ++a) {
      stride[a] = size[a] < 16 ? 1 : 2;
      EXPECT_EQ(thin->grid().size[a], (size[a] + stride[a] - 1) / stride[a]);
    }
    const auto& thin_size = thin->grid().size;
    for (int k = 0; k < thin_size[2]; ++k) {
      for (int j = 0; j < thin_size[1]; ++j) {
        for (int i = 0; i < thin_size[0]; ++i) {
          const std::array at{i * stride[0], j * stride[1], k * stride[2]};
          ASSERT_EQ(thin->at(i, j, k), whole->at(at[0], at[1], at[2]));
          const Eigen::Vector3d here = thin->grid().at(Eigen::Vector3d(i, j, k)).mm;
          const Eigen::Vector3d there = whole->grid().at(Eigen::Vector3d(at[0], at[1], at[2])).mm;
          ASSERT_LT((here - there).norm(), 1e-9);
        }
      }
    }
  }
}

TEST(ThinScenesTest, NoiseIsLessAndMaterialsAreNotMixed) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 20);
  const auto whole =
      test::make_volume(test::centred_grid({40, 40, 40}, {1, 1, 1}), [&](int i, int j, int) {
        return (i < 21 ? 50 : j < 15 ? 300 : 30000) + noise(random);
      });
  const auto thin = every_second_voxel(*whole);
  double squares = 0;
  for (int k = 0; k < 20; ++k) {
    for (int j = 0; j < 20; ++j) {
      for (int i = 0; i < 20; ++i) {
        const double expected = 2 * i < 21 ? 50 : 2 * j < 15 ? 300 : 30000;
        const double error = thin->at(i, j, k) - expected;
        ASSERT_LT(std::abs(error), 100) << i << ' ' << j << ' ' << k;
        squares += error * error / 8000;
      }
    }
  }
  EXPECT_LT(std::sqrt(squares), 0.6 * 20);
}

TEST(ThinScenesTest, VolumesAreThinnedOnce) {
  const auto grid = test::centred_grid({20, 20, 20}, {1, 1, 1});
  const auto ct = test::make_volume(grid, value_at);
  Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(100, 30, false));
  ThinScenes scenes;
  const auto first = scenes.of(scene);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->gradient_source, nullptr);
  scene.camera.eye_ct.mm.x() += 1;
  const auto second = scenes.of(scene);
  EXPECT_EQ(second->ct, first->ct);
  EXPECT_EQ(second->camera.eye_ct.mm, scene.camera.eye_ct.mm);
  scene.gradient_source = test::make_volume(grid, value_at);
  const auto shaded = scenes.of(scene);
  EXPECT_EQ(shaded->ct, first->ct);
  ASSERT_NE(shaded->gradient_source, nullptr);
  EXPECT_EQ(shaded->gradient_source->grid().size, shaded->ct->grid().size);
  scene.ct = test::make_volume(grid, value_at);
  EXPECT_NE(scenes.of(scene)->ct, first->ct);
  scene.predicates.emplace();
  EXPECT_FALSE(scenes.of(scene)) << "speckle would be another";
}

TEST(ThinScenesTest, AThinnerVolumeShowsTheSameSheetAtTheSamePlace) {
  Scene scene = test::sheet_scene(100, 33);
  const RenderedImage whole = test::draw(*make_cpu_engine({1}), scene);
  const RenderedImage thin = test::draw(*make_cpu_engine({1}), *ThinScenes().of(scene));
  constexpr float kSameBrightness = 0.3F;  // The sheet is twice as thick.
  EXPECT_GT(test::middle(whole).r, 0.1F);
  EXPECT_NEAR(test::middle(thin).r, test::middle(whole).r, kSameBrightness);
}

}  // namespace
}  // namespace nav::render
