// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/shaped_intensity.hpp"

#include <gtest/gtest.h>

#include "render/predicates/predicate_sampler.hpp"
#include "tests/render/predicates/predicate_scenes.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;

/// Voxel i has the stored value 5 i.
PredicateVolume ramp_volume(PredicateModel model) {
  const auto ultrasound = test::make_volume(test::centred_grid({51, 3, 3}, {1, 1, 1}),
                                            [](int i, int, int) { return 5 * i; });
  PredicateVolume volume{"ramp", ultrasound, {}};
  volume.predicates.model = std::move(model);
  return volume;
}

bool entry_is_true(const PredicateVolume& volume, int i) {
  const auto set = PredicateSet::create(volume.predicates, volume.ultrasound,
                                        {volume.ultrasound->grid(), {}, {}, {}});
  EXPECT_TRUE(test::has_value(set));
  return (PredicateSampler(*set).mask({1.0 * i, 1, 1}) & 1U) != 0;
}

TEST(ShapedIntensityTest, WithoutFloorsAndRampsNothingChanges) {
  auto volume = ramp_volume(test::model_of({{E::kind("intensity", {0.4, 0.8}), 1}}));
  const auto before = volume.ultrasound;
  ASSERT_TRUE(test::has_value(shape_intensity(volume, 0)));
  EXPECT_EQ(volume.ultrasound, before);
  EXPECT_TRUE(volume.predicates.features.volumes.empty());
}

TEST(ShapedIntensityTest, AFloorRaisesOnlyWhereItsPredicateIsTrue) {
  auto volume = ramp_volume(
      test::model_of({{E::kind("intensity", {0.1, 0.3}), 1}, {E::kind("intensity", {0.2, 1}), 1}}));
  volume.predicates.model.entries[0].floor = 0.5;
  ASSERT_TRUE(test::has_value(shape_intensity(volume, 0)));
  for (int i = 0; i < 51; ++i) {
    const int stored = 5 * i;
    const bool raised = stored >= 0.1 * 255 && stored <= 0.3 * 255;
    EXPECT_EQ(volume.ultrasound->values()[static_cast<std::size_t>(i)], raised ? 128 : stored) << i;
    EXPECT_EQ(entry_is_true(volume, i), raised) << "predicates test the intensity as it was, " << i;
  }
}

TEST(ShapedIntensityTest, ASoftThresholdIsARampAndMonotone) {
  constexpr double kSoft = 0.5;
  auto volume = ramp_volume(test::model_of({{E::kind("intensity", {0.4, 1e6}), 1}}));
  ASSERT_TRUE(test::has_value(shape_intensity(volume, kSoft)));
  int last = -1;
  for (int i = 0; i < 51; ++i) {
    const double intensity = 5 * i / 255.0;
    const double ramp = std::clamp((intensity - 0.4 + 0.2) / 0.2, 0.0, 1.0);
    EXPECT_EQ(entry_is_true(volume, i), intensity >= 0.2 - 1e-4) << i;
    if (ramp > 0) {
      const int value = volume.ultrasound->values()[static_cast<std::size_t>(i)];
      EXPECT_NEAR(value, 255 * ramp * intensity, 0.6) << i;
      EXPECT_GE(value, last);
      last = value;
    }
  }
}

TEST(ShapedIntensityTest, UnderANotTheRampLiesOnTheOtherSide) {
  auto volume = ramp_volume(test::model_of({{E::negation(E::kind("intensity", {0.4, 1e6})), 1}}));
  ASSERT_TRUE(test::has_value(shape_intensity(volume, 0.5)));
  for (int i = 0; i < 51; ++i) {
    const double intensity = 5 * i / 255.0;
    EXPECT_EQ(entry_is_true(volume, i), intensity < 0.4 - 1e-4) << i;
    const double share = 1 - std::clamp((intensity - 0.2) / 0.2, 0.0, 1.0);
    if (share > 0) {
      EXPECT_NEAR(volume.ultrasound->values()[static_cast<std::size_t>(i)], 255 * share * intensity,
                  0.6)
          << i;
    }
  }
}

TEST(ShapedIntensityTest, RejectsMovingPredicatesAndWrongShares) {
  auto volume = ramp_volume(test::model_of({{E::kind("target_distance", {-1, 5}), 1}}));
  EXPECT_TRUE(
      test::rejects(shape_intensity(volume, 0.2), ErrorCode::kUsage, {"entry 0", "target"}));
  for (const double share : {-0.1, 1.1, std::nan("")}) {
    EXPECT_TRUE(test::rejects(shape_intensity(volume, share), ErrorCode::kUsage, {"[0, 1]"}));
  }
  volume = ramp_volume(test::model_of({{E::kind("intensity", {0.1, 1}), 1}}));
  volume.predicates.model.entries[0].floor = 1.5;
  EXPECT_TRUE(
      test::rejects(shape_intensity(volume, 0), ErrorCode::kMalformedData, {"floor", "1.5"}));
}

TEST(ShapedIntensityTest, EveryEngineDrawsIt) {
  auto volume = ramp_volume(test::model_of({{E::kind("intensity", {0.4, 1e6}), 1}}));
  volume.predicates.model.entries[0].floor = 0.6;
  ASSERT_TRUE(test::has_value(shape_intensity(volume, 0.4)));
  const Scene scene = predicate_scene(volume, volume.predicates.model, 48, 36);
  const auto cpu = make_cpu_engine({});
  const auto reference = make_reference_engine();
  const RenderedImage a = test::draw(*cpu, scene);
  const RenderedImage b = test::draw(*reference, scene);
  double lit = 0;
  for (std::size_t i = 0; i < a.pixels.pixels().size(); ++i) {
    EXPECT_LE(test::difference(a.pixels.pixels()[i], b.pixels.pixels()[i]), 2.0F / 255);
    lit += a.pixels.pixels()[i].r > 0.1F ? 1 : 0;
  }
  EXPECT_GT(lit, 20);
}

}  // namespace
}  // namespace nav::render
