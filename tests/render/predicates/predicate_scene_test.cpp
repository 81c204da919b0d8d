// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests images by predicates against closed forms on each CPU engine, and tests what is rejected.
#include <cmath>
#include <limits>

#include "render/predicates/set.hpp"
#include "tests/render/predicates/predicate_scenes.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;

PredicateExpression everything() { return E::kind("intensity", {-1e6, 1e6}); }

/// A scene from far away along +y with parallel rays and one predicate that is true everywhere.
Scene frontal_scene(std::shared_ptr<const StoredVolume> ct, PredicateModel model) {
  Scene scene = test::plain_scene(std::move(ct), test::fog(0.1), test::frontal(80, 10, true));
  scene.predicates.emplace();
  scene.predicates->model = std::move(model);
  scene.predicates->termination_error = 0;
  return scene;
}

class PredicateSceneTest : public test::EngineTest {};
INSTANTIATE_TEST_SUITE_P(Engines, PredicateSceneTest, ::testing::ValuesIn(test::engine_cases()),
                         [](const auto& of) { return std::string(of.param.name); });

TEST_P(PredicateSceneTest, OpacityOfAConstantBlockFollowsItsLength) {
  constexpr float kTolerance = 2e-4F;  // 1024 entries of extinction, single precision.
  for (const Eigen::Vector3d& spacing : {Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(0.2, 0.2, 1)}) {
    for (const double step : {0.25, 1.0, 3.0}) {
      const auto ct = test::make_volume(test::centred_grid({61, 41, 31}, spacing),
                                        [](int, int, int) { return 102; });
      Scene scene = frontal_scene(ct, test::model_of({{everything(), 1}}, 0));
      scene.quality.step_voxels = step;
      scene.camera.orthographic_height_mm = 3;
      const double length_mm = 40 * spacing.y();
      const double alpha = 1 - std::pow(1 - 0.4, length_mm / scene.predicates->opacity_length_mm);
      EXPECT_NEAR(test::middle(test::draw(*engine_, scene)).r, 0.4 * alpha, kTolerance)
          << spacing.transpose() << ", step " << step;
    }
  }
}

TEST_P(PredicateSceneTest, NoRangeHoldsAnUndefinedFeature) {
  const VoxelGrid grid = test::centred_grid({21, 21, 21}, {1, 1, 1});
  const auto ct = test::make_volume(grid, [](int, int, int) { return 200; });
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double undefined : {std::nan(""), infinity, -infinity}) {
    // Only in the middle of the image. The last voxel has a value.
    const auto snr = test::feature(grid, feature::kSnr, [&](int i, int, int k) {
      return std::abs(i - 10) < 3 && std::abs(k - 10) < 3 ? undefined : 0.1 * i;
    });
    Scene scene = frontal_scene(ct, test::model_of({{E::kind("snr", {-1e6, 1e6}), 1}}, 0));
    scene.predicates->features.volumes.emplace(feature::kSnr, snr);
    scene.camera.orthographic_height_mm = 20;
    const RenderedImage image = test::draw(*engine_, scene);
    EXPECT_EQ(test::middle(image).r, 0) << undefined;
    EXPECT_GT(image.pixels.at(image.pixels.width() / 8, image.pixels.height() / 2).r, 0.7F);
  }
}

TEST_P(PredicateSceneTest, VoxelsOfNoPredicateAreInvisible) {
  const auto ct = test::make_volume(test::centred_grid({21, 21, 21}, {1, 1, 1}),
                                    [](int, int, int) { return 200; });
  Scene scene = frontal_scene(ct, test::model_of({{E::kind("intensity", {0, 0.5}), 1}}));
  scene.background_rgb = {0.25, 0.5, 0.75};
  const RgbaF pixel = test::middle(test::draw(*engine_, scene));
  EXPECT_EQ(pixel.r, 0.25F);
  EXPECT_EQ(pixel.b, 0.75F);
  scene.predicates->model =
      test::model_of({{everything(), 0}, {E::kind("intensity", {0, 0.1}), 1}});
  EXPECT_EQ(test::middle(test::draw(*engine_, scene)).r, 0.25F) << "importance 0 hides";
}

TEST_P(PredicateSceneTest, ClosedEndsHoldForStoredValuesAndQuantisedFeatures) {
  const VoxelGrid grid = test::centred_grid({21, 21, 21}, {1, 1, 1});
  const auto ct = test::make_volume(grid, [](int, int, int) { return 51; });  // 0.2
  const auto is_seen = [&](const E& expression) {
    Scene scene = frontal_scene(ct, test::model_of({{expression, 1}}));
    // 5.3 is neither end of the feature's range.
    scene.predicates->features.volumes.emplace(
        feature::kSnr, test::feature(grid, feature::kSnr, [](int i, int, int) {
          return i == 0 ? -7.1 : i == 20 ? 11.9 : 5.3;
        }));
    return test::middle(test::draw(*engine_, scene)).r > 0;
  };
  EXPECT_TRUE(is_seen(E::kind("intensity", {0.2, 0.2})));
  EXPECT_FALSE(is_seen(E::kind("intensity", {0.2001, 1})));
  EXPECT_TRUE(is_seen(E::kind("snr", {5.3, 9})));
  EXPECT_TRUE(is_seen(E::kind("snr", {1, 5.3})));
  EXPECT_FALSE(is_seen(E::kind("snr", {5.301, 9})));
}

TEST_P(PredicateSceneTest, AnImportantObjectShowsThroughAnObjectInFront) {
  // A bright wall in front (small y) and a target of half the intensity behind it.
  const auto ct =
      test::make_volume(test::centred_grid({21, 41, 21}, {1, 1, 1}), [](int, int j, int) {
        return j < 12 ? 204 : j > 28 ? 102 : 0;
      });
  const E wall = E::kind("intensity", {0.6, 1});
  const E target = E::kind("intensity", {0.2, 0.5});
  Scene scene = frontal_scene(ct, test::model_of({{wall, 1}, {target, 1}}, 0));
  const float alike = test::middle(test::draw(*engine_, scene)).r;
  EXPECT_NEAR(alike, 0.8, 0.01) << "alike, the wall hides all";
  scene.predicates->model = test::model_of({{wall, 0.02}, {target, 0.98}}, 0);
  const float focused = test::middle(test::draw(*engine_, scene)).r;
  EXPECT_NEAR(focused, 0.4 + std::exp(-std::pow(2 * 0.98, 2)) * 0.4, 0.02);
}

TEST_P(PredicateSceneTest, AnOpaqueSurfaceEndsTheRay) {
  const auto ct = test::make_volume(test::centred_grid({21, 41, 21}, {1, 1, 1}),
                                    [](int, int j, int) { return j > 25 ? 255 : 0; });
  Scene scene = frontal_scene(
      ct, test::model_of({{E::kind("intensity", {0.01, 1}), 0.9}, {everything(), 0.1}}));
  scene.plane = test::upright_plane(test::grey_image(20, 20, 51), 1, {0, 0, 10});
  EXPECT_NEAR(test::middle(test::draw(*engine_, scene)).r, 0.2, 1e-5) << "behind it, nothing";
}

TEST_P(PredicateSceneTest, DrawsThirtyTwoPredicatesWithOneImportance) {
  std::vector<std::pair<E, double>> entries;
  for (int j = 0; j < 32; ++j) {
    entries.emplace_back(E::kind("intensity", {0.01 * j, 0.01 * j + 0.3}), j == 20 ? 1 : 0);
  }
  const auto ct = test::small_ultrasound(test::centred_grid({25, 25, 25}, {1, 1, 1}), 4);
  Scene scene = frontal_scene(ct, test::model_of(std::move(entries)));
  const auto reference = make_reference_engine();
  const RenderedImage image = test::draw(*engine_, scene);  // There is no NaN.
  float sum = 0;
  std::size_t beyond = 0;
  const RenderedImage exact = test::draw(*reference, scene);
  for (std::size_t i = 0; i < image.pixels.pixels().size(); ++i) {
    sum += image.pixels.pixels()[i].g;
    if (test::difference(image.pixels.pixels()[i], exact.pixels.pixels()[i]) > 2.0F / 255) ++beyond;
  }
  EXPECT_GT(sum, 1);
  EXPECT_LE(beyond, 8U) << "of 825 pixels; values on the end of a range but for rounding";
}

TEST_P(PredicateSceneTest, DrawsUnusualVolumes) {
  const E angle = E::kind("gradient_angle", {0, M_PI, 1e-3});
  const auto model = test::model_of({{angle, 1}, {E::kind("snr", {0, 1}), 2}});
  for (const auto& size : {std::array<int, 3>{21, 21, 21}, {21, 1, 21}, {1, 21, 21}, {1, 1, 1}}) {
    for (const double value : {0.0, 90.0, 255.0}) {  // Black, constant, saturated.
      const VoxelGrid grid = test::centred_grid(size, {0.2, 0.2, 1});
      const auto ct = test::make_volume(grid, [&](int, int, int) { return value; });
      Scene scene = frontal_scene(ct, model);
      scene.predicates->scan = ParallelScan{{{0, -3, 0}}, {{0, 1, 0}}};
      ASSERT_TRUE(test::has_value(test::add_features(ct, 0, *scene.predicates)));
      scene.predicates->features.volumes.emplace(
          feature::kSnr,
          test::feature(grid, feature::kSnr, [](int, int, int) { return std::nan(""); }));
      EXPECT_EQ(test::middle(test::draw(*engine_, scene)).r, 0)
          << "no gradient and no SNR, so nothing is true";
      scene.predicates->model = test::model_of({{everything(), 1}});
      const float all = test::middle(test::draw(*engine_, scene)).r;
      EXPECT_EQ(all > 0, value > 0);
      // The features of a constant volume: no gradient, no tube, and the SNR of rounding.
      for (const char* name : {feature::kGradientMagnitude, feature::kVesselness, feature::kSnr}) {
        const double constant = std::string(name) == feature::kSnr ? value * std::sqrt(12.0) : 0;
        const auto volume = test::feature(grid, name, [&](int, int, int) { return constant; });
        scene.predicates->features.volumes.insert_or_assign(name, volume);
        const auto seen = [&](double low, double high) {
          scene.predicates->model = test::model_of({{E::kind(name, {low, high}), 1}});
          return test::middle(test::draw(*engine_, scene)).r;
        };
        EXPECT_EQ(seen(constant + 0.15, constant + 1), 0) << name << " of " << value;
        EXPECT_EQ(seen(constant, constant + 0.5), all) << name << " of " << value;
      }
    }
  }
}

TEST_P(PredicateSceneTest, AngleShowsLayersAcrossTheScanLine) {
  // Only y makes it brighter, so the gradients point along +y.
  const auto ct = test::make_volume(test::centred_grid({21, 21, 21}, {1, 1, 1}),
                                    [](int, int j, int) { return 10 * j + 20; });
  const auto seen = [&](const Eigen::Vector3d& into) {
    Scene scene =
        frontal_scene(ct, test::model_of({{E::kind("gradient_angle", {0, 0.3, 1e-3}), 1}}));
    scene.predicates->scan = ParallelScan{{{0, -10, 0}}, {into}};
    EXPECT_TRUE(test::has_value(test::add_features(ct, 0, *scene.predicates)));
    return test::middle(test::draw(*engine_, scene)).r > 0.1;
  };
  EXPECT_TRUE(seen({0, 3, 0}));
  EXPECT_FALSE(seen({0, -1, 0})) << "darker with depth";
  EXPECT_FALSE(seen({1, 0, 0}));
  EXPECT_TRUE(seen({0.2, 1, 0})) << "11 degrees";
  EXPECT_FALSE(seen({0.4, 1, 0})) << "22 degrees";
}

TEST_P(PredicateSceneTest, CutawayFadesByImportance) {
  const auto ct = test::make_volume(test::centred_grid({41, 41, 41}, {1, 1, 1}),
                                    [](int, int, int) { return 80; });
  Scene scene = frontal_scene(ct, test::model_of({{everything(), 1}}, 0));
  const float uncut = test::middle(test::draw(*engine_, scene)).r;
  scene.cutaway.emplace();
  scene.cutaway->overlay_mm = 0;
  scene.predicates->cutaway_importance = 0.5;
  scene.cutaway->polygons.push_back({{{{-9, 15, -9}}, {{9, 15, -9}}, {{9, 15, 9}}, {{-9, 15, 9}}}});
  const float cut = test::middle(test::draw(*engine_, scene)).r;
  EXPECT_LT(cut, uncut);
  scene.predicates->cutaway_importance = 1;
  EXPECT_NEAR(test::middle(test::draw(*engine_, scene)).r, uncut, 1e-6) << "1 is never cut";
}

TEST_P(PredicateSceneTest, ProjectionsIgnorePredicates) {
  const auto ct = test::small_ultrasound(test::centred_grid({15, 15, 15}, {1, 1, 1}), 4);
  Scene scene = frontal_scene(ct, test::model_of({{E::kind("intensity", {5, 6}), 1}}));
  scene.projection = Projection::kMaximum;
  scene.grey = {128, 256};
  const auto with = test::draw(*engine_, scene);
  scene.predicates.reset();
  EXPECT_EQ(test::max_difference(with, test::draw(*engine_, scene)), 0);
}

// ---- Errors ------------------------------------------------------------------------------------

class PredicateRejectionTest : public ::testing::Test {
 protected:
  ::testing::AssertionResult refused(std::initializer_list<std::string> pieces,
                                     ErrorCode code = ErrorCode::kMalformedData) const {
    return test::rejects(validate(scene_), code, pieces);
  }
  void use(std::vector<std::pair<E, double>> entries) {
    scene_.predicates->model = test::model_of(std::move(entries));
  }

  VoxelGrid grid_ = test::centred_grid({5, 6, 7}, {1, 1, 1});
  Scene scene_ = frontal_scene(test::make_volume(grid_, [](int, int, int) { return 9; }),
                               test::model_of({{everything(), 1}}));
};

TEST_F(PredicateRejectionTest, RejectsAnUnknownPredicate) {
  use({{E::kind("elasticity"), 1}});
  EXPECT_TRUE(refused({"entry 0", "elasticity", "vesselness"}, ErrorCode::kNotFound));
}

TEST_F(PredicateRejectionTest, RejectsRangesThatAreInvertedOrOutOfBounds) {
  use({{E::kind("intensity", {0.7, 0.2}), 1}});
  EXPECT_TRUE(refused({"entry 0", "intensity", "low <= high", "0.7 and 0.2"}));
  use({{E::kind("vesselness", {0, 1.5}), 1}});
  EXPECT_TRUE(refused({"vesselness.high", "[0, 1]", "1.5"}));
  use({{E::kind("snr", {std::nan(""), 1}), 1}});
  EXPECT_TRUE(refused({"snr.low", "nan"}));
  use({{E::kind("snr", {1}), 1}});
  EXPECT_TRUE(refused({"snr", "2 parameters", "found 1"}));
  use({{E::kind("label", {1.5}), 1}});
  EXPECT_TRUE(refused({"label", "whole number", "1.5"}));
}

TEST_F(PredicateRejectionTest, RejectsMissingFeaturesAndOtherGrids) {
  use({{E::kind("snr"), 1}});
  EXPECT_TRUE(refused({"entry 0: snr", "feature volume snr", "none"}));
  const VoxelGrid other = test::centred_grid({5, 6, 8}, {1, 1, 1});
  scene_.predicates->features.volumes.emplace(
      feature::kSnr, test::feature(other, feature::kSnr, [](int, int, int) { return 1; }));
  EXPECT_TRUE(refused({"feature snr", "5 x 6 x 7", "5 x 6 x 8"}));
  use({{E::kind("label"), 1}});
  EXPECT_TRUE(refused({"label", "label volume", "none"}));
  scene_.predicates->features.labels =
      *LabelVolume::create(other, std::vector<std::uint32_t>(other.voxel_count()), "layers");
  EXPECT_TRUE(refused({"layers", "5 x 6 x 7", "5 x 6 x 8"}));
}

TEST_F(PredicateRejectionTest, RejectsAMissingScanNeedleOrTarget) {
  use({{E::kind("gradient_angle"), 1}});
  EXPECT_TRUE(refused({"gradient_angle", "scan-line directions", "none"}));
  use({{E::kind("needle_distance"), 1}});
  EXPECT_TRUE(refused({"needle_distance", "needle", "none"}));
  use({{E::kind("target_distance"), 1}});
  EXPECT_TRUE(refused({"target_distance", "target", "none"}));
  scene_.predicates->scan = ParallelScan{{{0, 0, 0}}, {{0, 0, 0}}};
  EXPECT_TRUE(refused({"predicates.scan.into_ct", "direction"}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  scene_.predicates->scan = ParallelScan{{{0, 0, 0}}, {{0, nan, 0}}};
  EXPECT_TRUE(refused({"predicates.scan.into_ct", "NaN"}));
  scene_.predicates->scan = ParallelScan{{{0, nan, 0}}, {{0, 1, 0}}};
  EXPECT_TRUE(refused({"predicates.scan.face_ct"}));
  scene_.predicates->scan = FanScan{{{nan, 0, 0}}, 0};
  EXPECT_TRUE(refused({"predicates.scan.apex_ct"}));
  for (const double radius : {-1.0, nan, 2e7}) {
    scene_.predicates->scan = FanScan{{{0, 0, 0}}, radius};
    EXPECT_TRUE(refused({"predicates.scan.face_radius_mm"})) << radius;
  }
  scene_.predicates->scan = VoxelScan{};
  EXPECT_TRUE(refused({"scan.into_ct", "210 voxels", "found 0"}));
}

TEST_F(PredicateRejectionTest, AStaleOrLostNeedleHasNoDistances) {
  use({{E::kind("needle_distance"), 1}});
  scene_.needle = NeedleShape{
      .tip_ct = {{0, 0, 0}}, .hub_ct = {{0, 0, -9}}, .radius_mm = 0.8, .rgb = {1, 1, 1}};
  for (const SafetyState state :
       {SafetyState::kValid, SafetyState::kDegraded, SafetyState::kStale, SafetyState::kLost}) {
    scene_.needle->safety = {state, state == SafetyState::kValid ? "" : "no pose"};
    ASSERT_TRUE(position_of(scene_).needle);
    EXPECT_EQ(position_of(scene_).needle->a.allFinite(), state <= SafetyState::kDegraded);
  }
  scene_.needle.reset();
  EXPECT_FALSE(position_of(scene_).needle);
  PredicateScene lost = *scene_.predicates;
  lost.needle_lost = true;
  EXPECT_FALSE(same_drawing(*scene_.predicates, lost));
  scene_.predicates = lost;
  EXPECT_TRUE(test::has_value(validate(scene_)));
  EXPECT_FALSE(position_of(scene_).needle->a.allFinite());
}

TEST_F(PredicateRejectionTest, RejectsCyclesAndUnknownEntries) {
  use({{E::entry("entry 1"), 1}, {E::negation(E::entry("entry 0")), 1}});
  EXPECT_TRUE(refused({"cycle", "\"entry 0\" -> \"entry 1\" -> \"entry 0\""}));
  use({{E::entry("entry 0"), 1}});
  EXPECT_TRUE(refused({"cycle"}));
  use({{E::entry("nothing"), 1}});
  EXPECT_TRUE(refused({"entry 0", "\"nothing\""}));
}

TEST_F(PredicateRejectionTest, RejectsCombinationsThatAreEmptyOrTooDeep) {
  use({{E::all({}), 1}});
  EXPECT_TRUE(refused({"AND or OR", "found 0"}));
  E deep = everything();
  for (int i = 0; i < 20; ++i) deep = E::negation(deep);
  use({{deep, 1}});
  EXPECT_TRUE(refused({"at most 16 deep"}));
}

TEST_F(PredicateRejectionTest, RejectsTooManyPredicates) {
  scene_.predicates->model = {};
  EXPECT_TRUE(refused({"1 to 32", "found 0"}));
  std::vector<std::pair<E, double>> entries(32, {everything(), 1});
  std::vector<E> many;
  for (int i = 0; i < 33; ++i) many.push_back(E::kind("intensity", {0.01 * i, 1}));
  entries[0].first = E::any(many);
  use(entries);
  EXPECT_TRUE(refused({"at most 32 different"}));
  scene_.predicates->model.entries.push_back({"one more", everything()});
  EXPECT_TRUE(refused({"1 to 32", "found 33"}));
}

TEST_F(PredicateRejectionTest, RejectsInvalidNumbersOfTheScene) {
  scene_.predicates->intensity = {100, 100};
  EXPECT_TRUE(refused({"predicates.intensity.white", "above black"}));
  scene_.predicates->intensity = {};
  scene_.predicates->opacity_length_mm = 0;
  EXPECT_TRUE(refused({"opacity_length_mm"}));
  scene_.predicates->opacity_length_mm = 1;
  scene_.predicates->termination_error = std::nan("");
  EXPECT_TRUE(refused({"termination_error"}));
}

TEST_F(PredicateRejectionTest, PresetsAreValidAndAnUnknownNameListsThem) {
  for (const std::string& name : predicate_preset_names()) {
    const auto model = preset_predicates(name);
    ASSERT_TRUE(test::has_value(model)) << name;
    EXPECT_TRUE(test::has_value(validate(*model))) << name;
  }
  EXPECT_TRUE(test::rejects(preset_predicates("kidney"), ErrorCode::kNotFound,
                            {"carotid-context", "\"kidney\""}));
}

TEST(PredicateSetTest, CountsTheVoxelsOfScribbles) {
  const VoxelGrid grid = test::centred_grid({4, 1, 1}, {1, 1, 1});
  const auto ct = test::make_volume(grid, [](int i, int, int) { return 51 * (i + 1); });
  Scene scene = frontal_scene(ct, test::model_of({{E::kind("intensity", {0, 0.5}), 1},
                                                  {E::kind("intensity", {0.3, 1}), 1}}));
  const auto set = PredicateSet::create(*scene.predicates, ct, position_of(scene));
  ASSERT_TRUE(test::has_value(set));
  const std::vector<std::size_t> painted{0, 1, 2, 2};
  EXPECT_EQ(count_true(*set, painted), (std::vector<std::uint64_t>{2, 3}));
}

}  // namespace
}  // namespace nav::render
