// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/skipping/coarse_volumes.hpp"

#include <bit>
#include <gtest/gtest.h>

#include "nav/index.hpp"
#include "tests/render/predicates/predicate_scenes.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;

const std::array<int, 3> kEdges{385, 33, 7};  // The axes keep every fourth voxel, every second
                                              // voxel, and every voxel.

class CoarseVolumesTest : public ::testing::Test {
 protected:
  Scene scene_asking(std::vector<std::pair<E, double>> entries) {
    Scene scene = test::plain_scene(ct_, test::fog(0.1), test::frontal(80, 30, false));
    scene.predicates.emplace();
    scene.predicates->model = test::model_of(std::move(entries));
    scene.predicates->features = features_;
    return scene;
  }
  Scene coarse_of(const Scene& scene) {
    const auto set = PredicateSet::create(*scene.predicates, scene.ct, position_of(scene));
    EXPECT_TRUE(test::has_value(set));
    return coarse_volumes_.of(scene, *set);
  }
  std::shared_ptr<const StoredVolume> ct_ =
      test::small_ultrasound(test::centred_grid(kEdges, {1, 0.8, 0.9}), 5);
  Features features_ = test::random_features(ct_, 3);
  CoarseVolumes coarse_volumes_;
};

TEST_F(CoarseVolumesTest, EveryKeptVoxelKeepsItsPosition) {
  const Scene scene = scene_asking({{E::kind("snr", {0.1, 0.7}), 1}, {E::kind("label", {1}), 1}});
  const Scene coarse = coarse_of(scene);
  EXPECT_TRUE(test::has_value(validate(coarse)));
  const VoxelGrid& grid = coarse.ct->grid();
  EXPECT_EQ(grid.size, (std::array<int, 3>{97, 17, 7}));
  const StoredVolume& codes = *coarse.predicates->features.volumes.at(feature::kSnr).codes();
  const StoredVolume& whole = *features_.volumes.at(feature::kSnr).codes();
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const std::size_t from =
            (as_size(k) * as_size(kEdges[1]) + as_size(2 * j)) * as_size(kEdges[0]) +
            as_size(4 * i);
        const std::size_t to =
            (as_size(k) * as_size(grid.size[1]) + as_size(j)) * as_size(grid.size[0]) + as_size(i);
        ASSERT_EQ(coarse.ct->values()[to], ct_->values()[from]);
        ASSERT_EQ(codes.values()[to], whole.values()[from]);
        ASSERT_EQ(coarse.predicates->features.labels->bits()[to], features_.labels->bits()[from]);
        const Eigen::Vector3d here = grid.at(Eigen::Vector3d(i, j, k)).mm;
        const Eigen::Vector3d there = ct_->grid().at(Eigen::Vector3d(4 * i, 2 * j, k)).mm;
        ASSERT_LT((here - there).norm(), 1e-9);
      }
    }
  }
}

TEST_F(CoarseVolumesTest, EdgesStayPowersOfTwoOnlyIfTheyWere) {
  const auto edges = [](int n) {
    return coarse_grid(test::centred_grid({n, n, n}, {1, 1, 1})).size[0];
  };
  EXPECT_EQ(edges(256), 128);
  EXPECT_EQ(edges(255), 127);
  EXPECT_EQ(edges(254), 127);
  EXPECT_EQ(edges(1), 1);
  EXPECT_EQ(edges(15), 15);
  EXPECT_EQ(edges(16), 8);
  EXPECT_EQ(edges(384), 192);
  EXPECT_EQ(edges(385), 97);
  EXPECT_EQ(edges(512), 128);
  EXPECT_EQ(edges(511), 127);
  for (int n = 1; n < 600; ++n) {
    const bool was = std::has_single_bit(static_cast<unsigned>(n));
    const bool is = std::has_single_bit(static_cast<unsigned>(edges(n)));
    EXPECT_EQ(was, is) << n;
    const int stride = n < 16 ? 1 : n <= 384 ? 2 : 4;
    EXPECT_LE(stride * (edges(n) - 1), n - 1) << "beyond the last voxel, " << n;
    EXPECT_GE(stride * (edges(n) + 1), n) << "ends too early, " << n;
  }
}

TEST_F(CoarseVolumesTest, ComputesOnlyWhatIsNeededAndOnlyOnce) {
  const Scene first = coarse_of(scene_asking({{E::kind("snr", {0.1, 0.7}), 1}}));
  EXPECT_EQ(first.predicates->features.volumes.size(), 1U);
  EXPECT_FALSE(first.predicates->features.labels);
  const Scene other = coarse_of(scene_asking({{E::kind("vesselness", {0.1, 0.7}), 1}}));
  const Scene again = coarse_of(scene_asking({{E::kind("snr", {0.4, 0.7}), 1}}));
  EXPECT_EQ(again.ct, first.ct);
  EXPECT_EQ(again.predicates->features.volumes.at(feature::kSnr).codes(),
            first.predicates->features.volumes.at(feature::kSnr).codes());
  features_ = test::random_features(ct_, 8);
  const Scene later = coarse_of(scene_asking({{E::kind("snr", {0.1, 0.7}), 1}}));
  EXPECT_NE(later.predicates->features.volumes.at(feature::kSnr).codes(),
            first.predicates->features.volumes.at(feature::kSnr).codes());
  EXPECT_EQ(later.predicates->features.volumes.size(), 1U) << "of features that are gone";
}

TEST_F(CoarseVolumesTest, HoldsNothingThatTheSceneNoLongerOffers) {
  std::weak_ptr<const StoredVolume> snr = features_.volumes.at(feature::kSnr).codes();
  coarse_of(scene_asking({{E::kind("snr", {0.1, 0.7}), 1}, {E::kind("label", {1}), 1}}));
  features_ = test::random_features(ct_, 8);
  coarse_of(scene_asking({{E::kind("confidence", {0.1, 0.7}), 1}}));
  EXPECT_TRUE(snr.expired());
  std::weak_ptr<const StoredVolume> volume = ct_;
  coarse_volumes_.release();
  features_ = {};
  ct_.reset();
  EXPECT_TRUE(volume.expired());
}

}  // namespace
}  // namespace nav::render
