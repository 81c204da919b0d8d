// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/derived_features.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <random>

#include "render/features/snr.hpp"
#include "render/predicates/registry.hpp"
#include "tests/render/scene_support.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;

/// A dark tube of 2 mm radius along x in bright tissue. The voxels are 0.5 mm, and sound travels
/// along y.
std::shared_ptr<const StoredVolume> tube() {
  const VoxelGrid grid =
      test::centred_grid({40, 32, 32}, {0.5, 0.5, 0.5}, Eigen::Matrix3d::Identity());
  std::vector<std::int16_t> voxels;
  for (int k = 0; k < 32; ++k) {
    for (int j = 0; j < 32; ++j) {
      for (int i = 0; i < 40; ++i) {
        const Eigen::Vector3d p = grid.at({1.0 * i, 1.0 * j, 1.0 * k}).mm;
        voxels.push_back(std::hypot(p.y(), p.z()) < 2 ? 20 : 180);
      }
    }
  }
  return std::make_shared<const StoredVolume>(
      *StoredVolume::create(grid, std::move(voxels), "tube"));
}

PredicateScene asking_for(const std::vector<std::string>& kinds) {
  PredicateScene scene;
  std::vector<PredicateHistogram::Bar> bars;
  for (const std::string& kind : kinds) {
    scene.model.entries.push_back({kind, E::kind(kind)});
    bars.push_back({1.0 / static_cast<double>(kinds.size()), 0, 0.5});
  }
  scene.model.histogram = *PredicateHistogram::create(std::move(bars));
  return scene;
}

TEST(DerivedFeaturesTest, ComputesNothingThatNoPredicateNeeds) {
  features::DerivedVolumes service;
  PredicateScene scene = asking_for({"intensity"});
  ASSERT_TRUE(test::has_value(add_derived_features(tube(), {}, service, scene)));
  EXPECT_TRUE(scene.features.volumes.empty());
  EXPECT_EQ(service.counts().computed, 0U);
}

TEST(DerivedFeaturesTest, ComputesEachNeededFeatureOnceAndFindsTheTube) {
  const auto volume = tube();
  features::DerivedVolumes service;
  DerivedFeatureOptions options;
  options.vesselness.smallest_radius_mm = options.vesselness.largest_radius_mm = 2;
  options.vesselness.scales = 1;
  PredicateScene scene = asking_for({"vesselness", "snr"});
  ASSERT_TRUE(test::has_value(add_derived_features(volume, options, service, scene)));
  PredicateScene again = asking_for({"vesselness", "snr"});
  ASSERT_TRUE(test::has_value(add_derived_features(volume, options, service, again)));
  EXPECT_EQ(service.counts().computed, 2U);
  ASSERT_EQ(scene.features.volumes.size(), 2U);
  const FeatureVolume& vessel = scene.features.volumes.at(feature::kVesselness);
  const auto at = [&](int j, int k) {
    const auto code = vessel.codes()->values()[static_cast<std::size_t>((k * 32 + j) * 40 + 20)];
    return vessel.offset() + vessel.scale() * code;
  };
  EXPECT_GT(at(16, 16), 0.5);
  EXPECT_LT(at(4, 16), 0.05);
}

TEST(DerivedFeaturesTest, AVolumeShiftedWithItsBlackLevelHasEqualFeatures) {
  const std::vector<std::string> kinds{"snr", "vesselness", "confidence", "gradient_magnitude",
                                       "gradient_angle"};
  const auto derived = [&](int black) {
    const auto volume = tube();
    std::vector<std::int16_t> voxels(volume->values().begin(), volume->values().end());
    for (std::int16_t& v : voxels) v = static_cast<std::int16_t>(v + black);
    PredicateScene scene = asking_for(kinds);
    scene.intensity = {1.0 * black, 255.0 + black};
    scene.scan = ParallelScan{{{0, -10, 0}}, {{0, 1, 0}}};
    features::DerivedVolumes service;
    const auto shifted = std::make_shared<const StoredVolume>(
        *StoredVolume::create(volume->grid(), std::move(voxels), "tube"));
    EXPECT_TRUE(test::has_value(add_derived_features(shifted, {}, service, scene)));
    return scene.features.volumes;
  };
  const auto plain = derived(0);
  const auto shifted = derived(600);
  ASSERT_EQ(plain.size(), 6U);
  for (const auto& [name, feature] : plain) {
    const FeatureVolume& other = shifted.at(name);
    EXPECT_NEAR(other.scale(), feature.scale(), 1e-4 * feature.scale()) << name;
    EXPECT_NEAR(other.offset(), feature.offset(), 2 * feature.scale()) << name;
    int apart = 0;
    for (std::size_t n = 0; n < feature.codes()->values().size(); ++n) {
      apart += std::abs(feature.codes()->values()[n] - other.codes()->values()[n]) > 8 ? 1 : 0;
    }
    EXPECT_EQ(apart, 0) << name;
  }
}

TEST(DerivedFeaturesTest, NamesTheSourceOfEachChannel) {
  EXPECT_FALSE(source_of_channel(feature::kIntensity).derived);
  EXPECT_FALSE(source_of_channel(feature::kDepth).derived);
  EXPECT_FALSE(source_of_channel("none of them").derived);
  EXPECT_TRUE(source_of_channel(feature::kSnr).derived);
  EXPECT_FALSE(source_of_channel(feature::kSnr).scan_lines);
  EXPECT_TRUE(source_of_channel(feature::kConfidence).scan_lines);
  EXPECT_TRUE(source_of_channel(feature::kGradientMagnitude).gradient);
  EXPECT_FALSE(source_of_channel(feature::kGradientMagnitude).scan_lines);
  EXPECT_TRUE(source_of_channel(feature::kGradientAcross).gradient);
  EXPECT_TRUE(source_of_channel(feature::kGradientAcross).scan_lines);
}

/// 16-bit speckle beside a saturated slab.
std::shared_ptr<const StoredVolume> saturated() {
  const VoxelGrid grid = test::centred_grid({40, 32, 32}, {0.5, 0.5, 0.5});
  std::mt19937 random(6);
  std::normal_distribution<double> noise(0, 1);
  return test::make_volume(grid, [&](int, int j, int) {
    return j > 20 ? 32767.0 : 2000 + (60 + 10.0 * j) * noise(random);
  });
}

TEST(DerivedFeaturesTest, ASaturatedSlabDoesNotReduceTheResolutionOfTheSnr) {
  const auto volume = saturated();
  features::DerivedVolumes service;
  PredicateScene scene = asking_for({"snr"});
  ASSERT_TRUE(test::has_value(add_derived_features(volume, {}, service, scene)));
  const FeatureVolume& snr = scene.features.volumes.at(feature::kSnr);
  const auto truth = features::signal_to_noise(features::ScalarVolume::of(volume));
  ASSERT_TRUE(test::has_value(truth));
  EXPECT_LT(snr.quantum(), 0.016);
  int tissue = 0;
  int above = 0;
  for (std::size_t i = 0; i < truth->values->size(); ++i) {
    const double exact = static_cast<double>((*truth->values)[i]);
    above += exact > kMostSnr ? 1 : 0;
    const PredicateSample sample{
        {snr.offset() + snr.scale() * snr.codes()->values()[i]}, {snr.quantum()}, 0, {0, 0, 0}};
    EXPECT_NEAR(sample.value[0], std::min(exact, kMostSnr), 0.5 * snr.quantum() + 1e-4);
    for (const double low : {10.0, 12.6, 20.0}) {
      if (std::abs(exact - low) <= snr.quantum()) continue;
      ++tissue;
      const std::vector<double> upwards{low, 1e6};
      EXPECT_EQ((*find_predicate_kind("snr"))->test(sample, {}, upwards), exact >= low) << exact;
    }
  }
  EXPECT_GT(tissue, 1000);
  EXPECT_GT(above, 1000);
}

TEST(DerivedFeaturesTest, UnknownVoxelsDoNotEnterFeatures) {
  constexpr std::int16_t kNone = -7;
  const VoxelGrid grid = test::centred_grid({30, 24, 20}, {0.5, 0.5, 0.5});
  const auto at = [&](int i, int j, int k) {
    return static_cast<std::size_t>((k * grid.size[1] + j) * grid.size[0] + i);
  };
  // A ramp. Voxels that no image reached can have any value.
  const auto with = [&](int other) {
    return test::make_volume(grid, [&](int i, int j, int) {
      return i >= 15 && j >= 8 ? static_cast<double>(other) : 40.0 + 5 * j;
    });
  };
  PredicateScene scene = asking_for({"snr", "gradient_magnitude"});
  DerivedFeatureOptions options;
  options.unknown = kNone;
  options.gradient.smoothing_mm = 1;
  features::DerivedVolumes service;
  const auto volume = with(kNone);
  ASSERT_TRUE(test::has_value(add_derived_features(volume, options, service, scene)));
  for (const char* name : {feature::kSnr, feature::kGradientMagnitude}) {
    const FeatureVolume& found = scene.features.volumes.at(name);
    EXPECT_TRUE(found.has_undefined()) << name;
    EXPECT_EQ(found.codes()->values()[at(20, 12, 10)], FeatureVolume::kUndefined) << name;
    EXPECT_NE(found.codes()->values()[at(5, 12, 10)], FeatureVolume::kUndefined) << name;
  }
  // Beside unknown voxels the slope continues, as the known neighbours show.
  const FeatureVolume& magnitude = scene.features.volumes.at(feature::kGradientMagnitude);
  for (const int i : {13, 14}) {
    const double slope =
        magnitude.offset() + magnitude.scale() * magnitude.codes()->values()[at(i, 14, 10)];
    constexpr double kSlope = 5 / 0.5 / 255;
    EXPECT_NEAR(slope, kSlope, 0.02 * kSlope) << i;
  }
}

TEST(DerivedFeaturesTest, GradientsAreSharesOfWhitePerMillimetre) {
  // 4 per mm along y with a window of 200. The scan lines are inclined by 0.6 rad.
  const auto ramp = test::make_volume(test::centred_grid({9, 21, 9}, {1, 0.5, 1}),
                                      [](int, int j, int) { return 2 * j; });
  PredicateScene scene = asking_for({"gradient_magnitude", "gradient_angle"});
  scene.intensity = {20, 220};
  scene.scan = ParallelScan{{{0, 0, 0}}, {{std::sin(0.6), std::cos(0.6), 0}}};
  features::DerivedVolumes service;
  DerivedFeatureOptions options;
  options.gradient.smoothing_mm = 0;
  ASSERT_TRUE(test::has_value(add_derived_features(ramp, options, service, scene)));
  const auto middle = [&](const char* name) {
    const FeatureVolume& feature = scene.features.volumes.at(name);
    return feature.offset() + feature.scale() * feature.codes()->values()[(4 * 21 + 10) * 9 + 4];
  };
  EXPECT_NEAR(middle(feature::kGradientMagnitude), 0.02, 1e-7);
  EXPECT_NEAR(middle(feature::kGradientAlong), 0.02 * std::cos(0.6), 1e-7);
  EXPECT_NEAR(middle(feature::kGradientAcross), 0.02 * std::sin(0.6), 1e-7);
}

TEST(DerivedFeaturesTest, ConfidenceNeedsScanLines) {
  features::DerivedVolumes service;
  PredicateScene scene = asking_for({"confidence"});
  const auto refused = add_derived_features(tube(), {}, service, scene);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, testing::HasSubstr("no scan geometry"));
  scene.scan = ParallelScan{{{0, -8, 0}}, {{0, 1, 0}}};
  ASSERT_TRUE(test::has_value(add_derived_features(tube(), {}, service, scene)));
  EXPECT_EQ(scene.features.volumes.count(feature::kConfidence), 1U);
}

TEST(DerivedFeaturesTest, ConfidenceIsEqualForOneDirectionAndForDirectionsPerVoxel) {
  const auto volume = tube();
  const VoxelGrid& grid = volume->grid();
  features::DerivedVolumes service;
  PredicateScene parallel = asking_for({"confidence"});
  parallel.scan = ParallelScan{grid.at({0, 0, 0}), {{0, 1, 0}}};
  ASSERT_TRUE(test::has_value(add_derived_features(volume, {}, service, parallel)));
  PredicateScene each = asking_for({"confidence"});
  each.scan = VoxelScan{std::make_shared<const std::vector<Eigen::Vector3f>>(
      grid.voxel_count(), Eigen::Vector3f(0, 2, 0))};
  const auto refused = add_derived_features(volume, {}, service, each);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, testing::HasSubstr("feature depth"));
  std::vector<float> depth_mm;
  for (int k = 0; k < 32; ++k) {
    for (int j = 0; j < 32; ++j) depth_mm.insert(depth_mm.end(), 40, 0.5F * static_cast<float>(j));
  }
  each.features.volumes.emplace(feature::kDepth,
                                *FeatureVolume::create(grid, depth_mm, feature::kDepth));
  ASSERT_TRUE(test::has_value(add_derived_features(volume, {}, service, each)));
  const FeatureVolume& a = parallel.features.volumes.at(feature::kConfidence);
  const FeatureVolume& b = each.features.volumes.at(feature::kConfidence);
  double worst = 0;
  for (std::size_t i = 0; i < grid.voxel_count(); ++i) {
    worst = std::max(worst, std::abs(a.offset() + a.scale() * a.codes()->values()[i] - b.offset() -
                                     b.scale() * b.codes()->values()[i]));
  }
  constexpr double kSolved = 2e-3;  // Twice the allowed error of a solve, plus the rounding of
                                    // 16-bit directions.
  EXPECT_LT(worst, kSolved);
}

}  // namespace
}  // namespace nav::render
