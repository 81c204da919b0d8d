// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/skipping/predicate_brick_cache.hpp"

#include <gtest/gtest.h>

#include "tests/render/predicates/predicate_scenes.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;

class PredicateBrickCacheTest : public ::testing::Test {
 protected:
  PredicateSet set_of(const char* kind) {
    Scene scene = test::plain_scene(ct_, test::fog(0.1), test::frontal(80, 30, false));
    scene.predicates.emplace();
    scene.predicates->model = test::model_of({{E::kind(kind, {0.2, 0.7}), 1}});
    scene.predicates->features = features_;
    auto set = PredicateSet::create(*scene.predicates, scene.ct, position_of(scene));
    EXPECT_TRUE(test::has_value(set));
    return *std::move(set);
  }

  std::shared_ptr<const StoredVolume> ct_ =
      test::small_ultrasound(test::centred_grid({29, 26, 17}, {1, 1, 1}), 5);
  Features features_ = test::random_features(ct_, 3);
  PredicateBrickCache cache_;
};

TEST_F(PredicateBrickCacheTest, RangesAreKeptAsLongAsTheirVoxels) {
  EXPECT_EQ(cache_.missing_channels(set_of("snr")), 2U) << "the volume and its feature";
  cache_.update(set_of("snr"), 1);
  EXPECT_EQ(cache_.missing_channels(set_of("snr")), 0U);
  EXPECT_EQ(cache_.missing_channels(set_of("vesselness")), 1U);
  EXPECT_TRUE(cache_.prepare_channel(set_of("vesselness"), 1));
  EXPECT_FALSE(cache_.prepare_channel(set_of("vesselness"), 1));
  EXPECT_EQ(cache_.leaves().open.size(), static_cast<std::size_t>(cache_.grid().count.prod()));
  cache_.update(set_of("vesselness"), 1);
  EXPECT_EQ(cache_.missing_channels(set_of("snr")), 0U) << "the scene offers it still";
  features_ = test::random_features(ct_, 8);
  EXPECT_EQ(cache_.missing_channels(set_of("snr")), 1U);
  cache_.update(set_of("snr"), 1);
  EXPECT_EQ(cache_.missing_channels(set_of("snr")), 0U);
}

TEST_F(PredicateBrickCacheTest, LeavesOfAMovedObjectAreTestedAgain) {
  Scene scene = test::plain_scene(ct_, test::fog(0.1), test::frontal(80, 30, false));
  scene.predicates.emplace();
  scene.predicates->scan = ParallelScan{{{0, 0, 0}}, {{0, 1, 0}}};
  scene.needle = test::needle({-3, 0, 0}, {5, 2, 1});
  scene.spheres.push_back({{{2, 1, 0}}, 3});
  const auto set_of_kind = [&](const char* kind) {
    scene.predicates->model = test::model_of({{E::kind(kind, {1, 6}), 1}});
    auto set = PredicateSet::create(*scene.predicates, scene.ct, position_of(scene));
    EXPECT_TRUE(test::has_value(set));
    return *std::move(set);
  };
  const auto moved = [&](const char* kind) {
    (void)cache_.update(set_of_kind(kind), 1);
    EXPECT_FALSE(cache_.update(set_of_kind(kind), 1)) << kind;
    const auto before = cache_.leaves().open;
    Scene kept = scene;
    scene.needle->tip_ct.mm.y() += 4;
    scene.spheres[0].centre_ct.mm.y() += 4;
    scene.predicates->scan = ParallelScan{{{0, 4, 0}}, {{0, 1, 0}}};
    EXPECT_TRUE(cache_.update(set_of_kind(kind), 1)) << kind;
    EXPECT_NE(cache_.leaves().open, before) << kind;
    scene = std::move(kept);
  };
  moved("needle_distance");
  moved("target_distance");
  moved("depth");
  // A predicate set that depends on no position is not tested again.
  (void)cache_.update(set_of_kind("intensity"), 1);
  scene.needle->tip_ct.mm.y() += 4;
  EXPECT_FALSE(cache_.update(set_of_kind("intensity"), 1));
  // A lost needle has no position.
  scene.needle->safety = {SafetyState::kLost, "lost"};
  for (int time = 0; time < 2; ++time)
    EXPECT_TRUE(cache_.update(set_of_kind("needle_distance"), 1));
}

TEST_F(PredicateBrickCacheTest, HoldsOnlyWhatTheLastPredicateSetReads) {
  const std::weak_ptr<const StoredVolume> snr = features_.volumes.at(feature::kSnr).codes();
  cache_.update(set_of("snr"), 1);
  features_.volumes.erase(feature::kSnr);
  EXPECT_FALSE(snr.expired());
  cache_.update(set_of("vesselness"), 1);
  EXPECT_TRUE(snr.expired());
}

TEST_F(PredicateBrickCacheTest, PreparationAndUpdateGiveEqualLeaves) {
  PredicateBrickCache prepared;
  while (prepared.prepare_channel(set_of("confidence"), 1)) {
  }
  EXPECT_TRUE(prepared.update(set_of("confidence"), 1));
  cache_.update(set_of("confidence"), 1);
  EXPECT_EQ(prepared.leaves().sure, cache_.leaves().sure);
  EXPECT_EQ(prepared.leaves().open, cache_.leaves().open);
}

}  // namespace
}  // namespace nav::render
