// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/half_volumes.hpp"

#include <bit>
#include <gtest/gtest.h>

#include "nav/index.hpp"
#include "tests/render/predicates/predicate_scenes.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;

const std::array<int, 3> kEdges{33, 20, 7};  // Odd, even, too few to be halved.

class HalfVolumesTest : public ::testing::Test {
 protected:
  Scene scene_asking(std::vector<std::pair<E, double>> entries) {
    Scene scene = test::plain_scene(ct_, test::fog(0.1), test::frontal(80, 30, false));
    scene.predicates.emplace();
    scene.predicates->model = test::model_of(std::move(entries));
    scene.predicates->features = features_;
    return scene;
  }
  Scene half_of(const Scene& scene) {
    const auto set = PredicateSet::create(*scene.predicates, scene.ct, place_of(scene));
    EXPECT_TRUE(test::has_value(set));
    return halves_.of(scene, *set);
  }
  std::shared_ptr<const Volume> ct_ =
      test::small_ultrasound(test::centred_grid(kEdges, {1, 0.8, 0.9}), 5);
  Features features_ = test::random_features(ct_, 3);
  HalfVolumes halves_;
};

TEST_F(HalfVolumesTest, EverySecondVoxelStaysWhereItIs) {
  const Scene scene = scene_asking({{E::kind("snr", {0.1, 0.7}), 1}, {E::kind("label", {1}), 1}});
  const Scene half = half_of(scene);
  EXPECT_TRUE(test::has_value(validate(half)));
  const VoxelGrid& grid = half.ct->grid();
  EXPECT_EQ(grid.size, (std::array<int, 3>{17, 10, 7}));
  const Volume& codes = *half.predicates->features.volumes.at(feature::kSnr).codes();
  const Volume& whole = *features_.volumes.at(feature::kSnr).codes();
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const std::size_t from =
            (as_size(k) * as_size(kEdges[1]) + as_size(2 * j)) * as_size(kEdges[0]) +
            as_size(2 * i);
        const std::size_t to =
            (as_size(k) * as_size(grid.size[1]) + as_size(j)) * as_size(grid.size[0]) + as_size(i);
        ASSERT_EQ(half.ct->hu()[to], ct_->hu()[from]);
        ASSERT_EQ(codes.hu()[to], whole.hu()[from]);
        ASSERT_EQ(half.predicates->features.labels->bits()[to], features_.labels->bits()[from]);
        const Eigen::Vector3d here = grid.at(Eigen::Vector3d(i, j, k)).mm;
        const Eigen::Vector3d there = ct_->grid().at(Eigen::Vector3d(2 * i, 2 * j, k)).mm;
        ASSERT_LT((here - there).norm(), 1e-9);
      }
    }
  }
}

TEST_F(HalfVolumesTest, EdgesArePowersOfTwoOnlyWhereTheyWere) {
  const auto edges = [](int n) {
    return half_grid(test::centred_grid({n, n, n}, {1, 1, 1})).size[0];
  };
  EXPECT_EQ(edges(256), 128);
  EXPECT_EQ(edges(255), 127);
  EXPECT_EQ(edges(254), 127);
  EXPECT_EQ(edges(1), 1);
  EXPECT_EQ(edges(15), 15);
  EXPECT_EQ(edges(16), 8);
  for (int n = 1; n < 600; ++n) {
    const bool was = std::has_single_bit(static_cast<unsigned>(n));
    const bool is = std::has_single_bit(static_cast<unsigned>(edges(n)));
    EXPECT_EQ(was, is) << n;
    EXPECT_LE(2 * (edges(n) - 1), n < 16 ? 2 * n : n - 1) << "beyond the last voxel";
  }
}

TEST_F(HalfVolumesTest, OnlyWhatIsAskedForIsMadeAndOnlyOnce) {
  const Scene first = half_of(scene_asking({{E::kind("snr", {0.1, 0.7}), 1}}));
  EXPECT_EQ(first.predicates->features.volumes.size(), 1U);
  EXPECT_FALSE(first.predicates->features.labels);
  const Scene other = half_of(scene_asking({{E::kind("vesselness", {0.1, 0.7}), 1}}));
  const Scene again = half_of(scene_asking({{E::kind("snr", {0.4, 0.7}), 1}}));
  EXPECT_EQ(again.ct, first.ct);
  EXPECT_EQ(again.predicates->features.volumes.at(feature::kSnr).codes(),
            first.predicates->features.volumes.at(feature::kSnr).codes());
  features_ = test::random_features(ct_, 8);
  const Scene later = half_of(scene_asking({{E::kind("snr", {0.1, 0.7}), 1}}));
  EXPECT_NE(later.predicates->features.volumes.at(feature::kSnr).codes(),
            first.predicates->features.volumes.at(feature::kSnr).codes());
  EXPECT_EQ(later.predicates->features.volumes.size(), 1U) << "of features that are gone";
}

TEST_F(HalfVolumesTest, NothingIsHeldThatIsNoMoreOffered) {
  std::weak_ptr<const Volume> snr = features_.volumes.at(feature::kSnr).codes();
  half_of(scene_asking({{E::kind("snr", {0.1, 0.7}), 1}, {E::kind("label", {1}), 1}}));
  features_ = test::random_features(ct_, 8);
  half_of(scene_asking({{E::kind("confidence", {0.1, 0.7}), 1}}));
  EXPECT_TRUE(snr.expired());
  std::weak_ptr<const Volume> volume = ct_;
  halves_.release();
  features_ = {};
  ct_.reset();
  EXPECT_TRUE(volume.expired());
}

}  // namespace
}  // namespace nav::render
