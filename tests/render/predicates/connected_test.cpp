// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/connected.hpp"

#include <gtest/gtest.h>

#include "render/predicates/predicate_sampler.hpp"
#include "tests/render/predicates/predicate_scenes.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;

/// A bar of 3 x 3 x 9 voxels and a speck of 2 voxels, in voxels of 0.5 x 1 x 2 mm: 81 and 2 mm³.
bool in_bar(int i, int j, int k) { return i >= 3 && i < 6 && j >= 3 && j < 6 && k >= 2 && k < 11; }
bool in_speck(int i, int j, int k) { return (i == 10 || i == 11) && j == 10 && k == 6; }

PredicateVolume bar_and_speck(PredicateModel model) {
  const auto ultrasound = test::make_volume(
      test::centred_grid({16, 16, 13}, {0.5, 1, 2}),
      [](int i, int j, int k) { return in_bar(i, j, k) || in_speck(i, j, k) ? 200 : 10; });
  PredicateVolume volume{"planted", ultrasound, {}};
  volume.predicates.model = std::move(model);
  return volume;
}

/// Voxels where entry 0 is true.
std::size_t count_entry(const PredicateVolume& volume) {
  const auto set = PredicateSet::create(volume.predicates, volume.ultrasound,
                                        {volume.ultrasound->grid(), {}, {}, {}});
  EXPECT_TRUE(test::has_value(set));
  const PredicateSampler sampler(*set);
  std::size_t count = 0;
  for (int k = 0; k < 13; ++k) {
    for (int j = 0; j < 16; ++j) {
      for (int i = 0; i < 16; ++i) count += sampler.mask({1.0 * i, 1.0 * j, 1.0 * k}) & 1U;
    }
  }
  return count;
}

E bright_voxels() { return E::kind("intensity", {0.5, 1}); }

TEST(ConnectedTest, KeepsPartsOfAtLeastTheStatedVolume) {
  const std::size_t bar = 81;
  for (const auto& [least_mm3, expected] : {std::pair(0.0, bar + 2),
                                            {2.0, bar + 2},
                                            {2.001, bar},
                                            {81.0, bar},
                                            {81.001, std::size_t{0}}}) {
    auto volume = bar_and_speck(test::model_of({{E::connected(bright_voxels(), least_mm3), 1}}));
    ASSERT_TRUE(test::has_value(resolve_connected(volume)));
    EXPECT_FALSE(has_connected(volume.predicates.model));
    EXPECT_EQ(count_entry(volume), expected) << least_mm3;
  }
}

TEST(ConnectedTest, NestsNegatesAndFollowsReferences) {
  PredicateModel model =
      test::model_of({{E::all({bright_voxels(), E::negation(E::entry("entry 1"))}), 1},
                      {E::connected(E::connected(bright_voxels(), 1), 50), 1}});
  auto volume = bar_and_speck(model);
  ASSERT_TRUE(test::has_value(resolve_connected(volume)));
  EXPECT_EQ(count_entry(volume), 2U) << "bright, but not in the large part";
}

TEST(ConnectedTest, LeavesGivenLabelsAlone) {
  auto volume = bar_and_speck(
      test::model_of({{E::all({E::kind("label", {1}), E::connected(bright_voxels(), 50)}), 1}}));
  std::vector<std::uint32_t> bits(16 * 16 * 13, 0);
  for (std::size_t i = 0; i < bits.size(); i += 2) bits[i] = 1;
  volume.predicates.features.labels =
      *LabelVolume::create(volume.ultrasound->grid(), bits, "given");
  ASSERT_TRUE(test::has_value(resolve_connected(volume)));
  const auto found = volume.predicates.features.labels->bits();
  for (std::size_t i = 0; i < bits.size(); ++i) EXPECT_EQ(found[i] & 1U, bits[i]);
  EXPECT_GT(count_entry(volume), 20U);
  EXPECT_LT(count_entry(volume), 81U);
}

TEST(ConnectedTest, RejectsWhatCannotBeResolved) {
  auto needle =
      bar_and_speck(test::model_of({{E::connected(E::kind("needle_distance", {-1, 5}), 5), 1}}));
  EXPECT_TRUE(test::rejects(resolve_connected(needle), ErrorCode::kUsage,
                            {"entry 0", "connected", "needle"}));
  auto crowded = bar_and_speck(test::model_of({{E::connected(bright_voxels(), 5), 1}}));
  crowded.predicates.features.labels = *LabelVolume::create(
      crowded.ultrasound->grid(), std::vector<std::uint32_t>(16 * 16 * 13, ~0U), "given");
  EXPECT_TRUE(test::rejects(resolve_connected(crowded), ErrorCode::kUsage, {"32"}));
  auto negative = bar_and_speck(test::model_of({{E::connected(bright_voxels(), -1), 1}}));
  EXPECT_TRUE(
      test::rejects(resolve_connected(negative), ErrorCode::kMalformedData, {"least_mm3", "-1"}));
  const auto unresolved = bar_and_speck(test::model_of({{E::connected(bright_voxels(), 5), 1}}));
  EXPECT_TRUE(test::rejects(PredicateSet::create(unresolved.predicates, unresolved.ultrasound,
                                                 {unresolved.ultrasound->grid(), {}, {}, {}}),
                            ErrorCode::kMalformedData, {"connected"}));
}

}  // namespace
}  // namespace nav::render
