// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compares the predicates of the CPU engine with the reference and with itself.

#include "tests/render/predicates/predicate_scenes.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;

double share_beyond(const RenderedImage& a, const RenderedImage& b, float limit) {
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < a.pixels.pixels().size(); ++i) {
    if (test::difference(a.pixels.pixels()[i], b.pixels.pixels()[i]) > limit) ++beyond;
  }
  return static_cast<double>(beyond) / static_cast<double>(a.pixels.pixels().size());
}

VoxelGrid grid_of(int i) {
  const Eigen::Vector3d spacing =
      i % 3 == 0 ? Eigen::Vector3d(0.4, 0.4, 2) : Eigen::Vector3d(1, 0.8, 0.9);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  if (i % 2 == 1) {
    turn = Eigen::AngleAxisd(0.3 + i, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix() *
           Eigen::Vector3d(1, -1, 1).asDiagonal();
  }
  if (i % 7 == 6) return test::centred_grid({25, 17, 1}, spacing, turn);
  return test::centred_grid({29, 26, 17 + 8 * (i % 2)}, spacing, turn);
}

class PredicateEngineTest : public ::testing::TestWithParam<CpuLanes> {};
INSTANTIATE_TEST_SUITE_P(Instructions, PredicateEngineTest, test::every_lanes(), test::lanes_name);

TEST_P(PredicateEngineTest, SkippingGivesBitIdenticalImages) {
  std::mt19937 random(GetParam() == CpuLanes::kPortable ? 2 : 1);
  const auto engine = make_cpu_engine({1, GetParam()});
  std::uint64_t with = 0;
  std::uint64_t without = 0;
  for (int v = 0; v < 14; ++v) {
    const auto ct = test::small_ultrasound(grid_of(v), static_cast<unsigned>(v));
    const Features features = test::random_features(ct, static_cast<unsigned>(v));
    for (int s = 0; s < 12; ++s) {
      Scene scene = test::random_predicate_scene(random, ct, features);
      if (s % 3 == 0) scene.predicates->termination_error = 0;
      if (s % 3 == 1) scene.predicates->opacity_length_mm = 0.2;
      const RenderedImage skipped = test::draw(*engine, scene);
      scene.quality.skip_empty_bricks = false;
      const RenderedImage full = test::draw(*engine, scene);
      ASSERT_TRUE(test::same_bytes(skipped, full))
          << "volume " << v << ", scene " << s << ": " << test::max_difference(skipped, full);
      with += skipped.statistics.volume_samples;
      without += full.statistics.volume_samples;
    }
  }
  EXPECT_LT(with, without) << "nothing was skipped";
}

TEST_P(PredicateEngineTest, DarkTissueIsNotTreatedAsBlack) {
  const auto engine = make_cpu_engine({1, GetParam()});
  const auto ct = test::make_volume(test::centred_grid({40, 40, 40}, {1, 1, 1}),
                                    [](int i, int, int) { return i < 20 ? -100 : 2; });
  Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(80, 30, true));
  scene.predicates.emplace();
  scene.predicates->model =
      test::model_of({{PredicateExpression::kind("intensity", {-1, 1}), 1}}, 0);
  const RenderedImage skipped = test::draw(*engine, scene);
  scene.quality.skip_empty_bricks = false;
  const RenderedImage full = test::draw(*engine, scene);
  EXPECT_TRUE(test::same_bytes(skipped, full));
  EXPECT_LT(skipped.statistics.volume_samples, full.statistics.volume_samples);
  // 39 mm with an opacity of 2 / 255 for each 2 mm.
  const double alpha = 1 - std::pow(1 - 2.0 / 255, 39 / scene.predicates->opacity_length_mm);
  const auto& pixels = skipped.pixels;
  EXPECT_NEAR(pixels.at(3 * pixels.width() / 4, pixels.height() / 2).r, alpha * 2 / 255, 1e-4);
}

TEST_P(PredicateEngineTest, LeapsOverBricksWithoutTheTarget) {
  const auto engine = make_cpu_engine({1, GetParam()});
  const VoxelGrid grid = test::centred_grid({64, 64, 64}, {0.5, 0.5, 0.5});
  const auto ct = test::small_ultrasound(grid, 3);
  Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(80, 30, false));
  scene.predicates.emplace();
  scene.predicates->model =
      test::model_of({{PredicateExpression::kind("vesselness", {0.5, 1}), 1}});
  scene.predicates->features.volumes.emplace(
      feature::kVesselness, test::feature(grid, feature::kVesselness, [](int, int j, int k) {
        return std::exp(-0.1 * (std::pow(j - 38, 2) + std::pow(k - 32, 2)));
      }));
  const RenderedImage skipped = test::draw(*engine, scene);
  scene.quality.skip_empty_bricks = false;
  const RenderedImage full = test::draw(*engine, scene);
  EXPECT_TRUE(test::same_bytes(skipped, full));
  EXPECT_LT(5 * skipped.statistics.volume_samples, full.statistics.volume_samples);
}

TEST_P(PredicateEngineTest, AgreesWithTheReferenceOnRandomScenes) {
  constexpr float kTwoGreyLevels = 2.0F / 255;
  constexpr double kShare = 0.002;  // Share of values that lie at an end of a range, except for
                                    // rounding.
  std::mt19937 random(11);
  const auto engine = make_cpu_engine({0, GetParam()});
  const auto reference = make_reference_engine();
  double beyond = 0;
  constexpr int kScenes = 70;
  for (int i = 0; i < kScenes; ++i) {
    const auto ct = test::small_ultrasound(grid_of(i), static_cast<unsigned>(i));
    Scene scene = test::random_predicate_scene(random, ct,
                                               test::random_features(ct, static_cast<unsigned>(i)));
    scene.predicates->termination_error = 0;
    const double share =
        share_beyond(test::draw(*engine, scene), test::draw(*reference, scene), kTwoGreyLevels);
    EXPECT_LT(share, 0.02) << i;
    beyond += share / kScenes;
  }
  EXPECT_LE(beyond, kShare);
}

TEST_P(PredicateEngineTest, EarlyTerminationStaysWithinItsError) {
  std::mt19937 random(5);
  const auto engine = make_cpu_engine({0, GetParam()});
  std::uint64_t with = 0;
  std::uint64_t without = 0;
  float worst = 0;
  for (int i = 0; i < 60; ++i) {
    const auto ct = test::small_ultrasound(grid_of(i), static_cast<unsigned>(i));
    Scene scene = test::random_predicate_scene(random, ct,
                                               test::random_features(ct, static_cast<unsigned>(i)));
    scene.predicates->opacity_length_mm = 0.15;
    const RenderedImage fast = test::draw(*engine, scene);
    scene.predicates->termination_error = 0;
    const RenderedImage full = test::draw(*engine, scene);
    worst = std::max(worst, test::max_difference(fast, full));
    with += fast.statistics.volume_samples;
    without += full.statistics.volume_samples;
  }
  EXPECT_LE(worst, 1.0F / 255 + 1e-5F);
  EXPECT_LT(with, without * 9 / 10) << "nothing was left out";
}

TEST_P(PredicateEngineTest, LayersOfNearlyEqualImportanceStayWithinTheirError) {
  const auto engine = make_cpu_engine({0, GetParam()});
  test::expect_layers_within_error([&](const Scene& scene) { return test::draw(*engine, scene); });
}

TEST_P(PredicateEngineTest, FindsTheAppearanceOfManyLeafCombinations) {
  constexpr float kTwoGreyLevels = 2.0F / 255;
  constexpr double kShare = 0.002;  // Share of values that lie at an end of a range, except for
                                    // rounding.
  const VoxelGrid grid = test::centred_grid({33, 30, 20}, {1, 1, 1});
  const auto ct = test::small_ultrasound(grid, 9);
  const auto engine = make_cpu_engine({1, GetParam()});
  const auto reference = make_reference_engine();
  for (const std::size_t leaves : {4U, 5U, 6U, 7U, 9U}) {
    for (const bool few : {true, false}) {
      std::vector<std::pair<E, double>> entries;
      for (std::size_t j = 0; j < leaves; ++j) {
        const double low = 0.05 + 0.07 * static_cast<double>(j);
        const auto steep = E::kind("gradient_magnitude", {0.3 * low, 1e6});
        entries.emplace_back(j % 2 == 0 ? E::kind("intensity", {low, 1}) : steep,
                             few ? 1 : 1 + 0.3 * static_cast<double>(j));
      }
      // If \p few, the leaves of one entry have one appearance.
      std::vector<std::pair<E, double>> sets = entries;
      if (few) {
        std::vector<E> all;
        for (const auto& entry : entries) all.push_back(entry.first);
        sets = {{E::any(all), 0.7}, {E::all(all), 0.3}};
      }
      Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(50, 30, false));
      scene.predicates.emplace();
      scene.predicates->model = test::model_of(sets);
      scene.predicates->opacity_length_mm = 3;
      ASSERT_TRUE(test::has_value(test::add_features(ct, 0.4, *scene.predicates)));
      EXPECT_LE(
          share_beyond(test::draw(*engine, scene), test::draw(*reference, scene), kTwoGreyLevels),
          kShare)
          << leaves << " leaves, " << (few ? "few" : "many") << " looks";
    }
  }
}

TEST_P(PredicateEngineTest, WhiteAndNearlyWhiteAreAsOpaqueAsInTheReference) {
  constexpr float kTolerance = 2e-3F;
  const VoxelGrid grid = test::centred_grid({30, 30, 30}, {1, 1, 1});
  // From 250 to above 255 along x. Some cells are completely white and some not at all.
  const auto ct = test::make_volume(grid, [](int i, int j, int) { return 250 + i / 4 - j % 2; });
  Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(50, 30, true));
  scene.predicates.emplace();
  scene.predicates->model = test::model_of({{E::kind("intensity", {0, 1e6}), 1}}, 0);
  const auto engine = make_cpu_engine({1, GetParam()});
  for (const double length_mm : {3000.0, 100.0}) {
    scene.predicates->opacity_length_mm = length_mm;
    const RenderedImage image = test::draw(*engine, scene);
    const RenderedImage expected = test::draw(*make_reference_engine(), scene);
    const auto& middle = expected.pixels.at(expected.pixels.width() / 2, 15);
    EXPECT_GT(middle.a, 0.02F) << length_mm;
    EXPECT_LT(test::max_difference(image, expected), kTolerance) << length_mm;
  }
}

TEST(PredicateCpuEngineTest, AllVectorInstructionsGiveEqualBytes) {
  const auto eight = make_cpu_engine({0, CpuLanes::kAvx2});
  const auto sixteen = make_cpu_engine({0, CpuLanes::kAvx512});
  if (sixteen->device().substr(0, 7) != "AVX-512") GTEST_SKIP() << "this processor has no AVX-512";
  std::mt19937 random(24);
  for (int i = 0; i < 60; ++i) {
    const auto ct = test::small_ultrasound(grid_of(i), static_cast<unsigned>(i));
    Scene scene = test::random_predicate_scene(random, ct,
                                               test::random_features(ct, static_cast<unsigned>(i)));
    // Each ray ends early by itself. The look-ups of its neighbours must not matter.
    if (i % 3 != 0) scene.predicates->opacity_length_mm = 0.05 + 0.1 * (i % 3);
    if (i % 2 != 0) scene.cutaway.reset();
    const RenderedImage image = test::draw(*sixteen, scene);
    EXPECT_TRUE(test::same_bytes(test::draw(*eight, scene), image)) << i;
  }
}

TEST(PredicateCpuEngineTest, PrefetchingDoesNotChangeTheImage) {
  // More than 3 million voxels. The features are prefetched together with them.
  constexpr float kTwoGreyLevels = 2.0F / 255;
  constexpr double kShare = 0.002;  // Share of values that lie at an end of a range, except for
                                    // rounding.
  const auto ct = test::small_ultrasound(test::centred_grid({150, 145, 142}, {0.5, 0.5, 0.5}), 5);
  std::mt19937 random(7);
  Scene scene = test::random_predicate_scene(random, ct, test::random_features(ct, 5));
  scene.cutaway.reset();
  scene.camera = test::frontal(120, 60, false);
  scene.width = 40;
  scene.height = 30;
  const RenderedImage expected = test::draw(*make_reference_engine(), scene);
  ASSERT_GT(std::abs(expected.pixels.at(20, 15).r - scene.background_rgb[0]), 0.05);
  for (const CpuLanes lanes : {CpuLanes::kPortable, CpuLanes::kAvx2, CpuLanes::kAvx512}) {
    const auto engine = make_cpu_engine({0, lanes});
    EXPECT_LE(share_beyond(test::draw(*engine, scene), expected, kTwoGreyLevels), kShare)
        << engine->device();
  }
}

TEST(PredicateCpuEngineTest, VectorAndPortablePathsAgree) {
  constexpr float kTolerance = 1e-4F;
  const auto vector = make_cpu_engine({0});
  const auto portable = make_cpu_engine({0, CpuLanes::kPortable});
  if (vector->device().substr(0, 3) != "AVX") GTEST_SKIP() << "this processor has no AVX2";
  std::mt19937 random(4);
  double beyond = 0;
  for (int i = 0; i < 30; ++i) {
    const auto ct = test::small_ultrasound(grid_of(i), static_cast<unsigned>(i));
    Scene scene = test::random_predicate_scene(random, ct,
                                               test::random_features(ct, static_cast<unsigned>(i)));
    scene.predicates->termination_error = 0;
    beyond +=
        share_beyond(test::draw(*vector, scene), test::draw(*portable, scene), kTolerance) / 30;
  }
  EXPECT_LT(beyond, 0.002);
}

TEST(PredicateCpuEngineTest, ImageDoesNotDependOnTheNumberOfThreads) {
  std::mt19937 random(3);
  const auto one = make_cpu_engine({1});
  const auto two = make_cpu_engine({2});
  for (int i = 0; i < 8; ++i) {
    const auto ct = test::small_ultrasound(grid_of(i), static_cast<unsigned>(i));
    Scene scene = test::random_predicate_scene(random, ct,
                                               test::random_features(ct, static_cast<unsigned>(i)));
    scene.width = 91;
    scene.height = 67;
    EXPECT_TRUE(test::same_bytes(test::draw(*one, scene), test::draw(*two, scene))) << i;
  }
}

TEST(PredicateCpuEngineTest, CachesFollowEveryEdit) {
  std::mt19937 random(6);
  const auto kept = make_cpu_engine();
  const auto ct = test::small_ultrasound(grid_of(1), 1);
  const Features features = test::random_features(ct, 1);
  Scene scene = test::random_predicate_scene(random, ct, features);
  const auto check = [&](const char* what) {
    EXPECT_TRUE(test::same_bytes(test::draw(*kept, scene), test::draw(*make_cpu_engine(), scene)))
        << what;
  };
  check("first");
  scene.predicates->model.histogram.drag(0, 0.3);
  check("an importance");
  scene.predicates->model = test::random_model(random);
  EXPECT_TRUE(test::has_value(test::add_features(ct, 0.4, *scene.predicates)));
  check("another set");
  scene.needle->tip_ct.mm.x() += 3;
  check("the needle");
  scene.predicates->intensity.white = 180;
  check("the window");
  scene.predicates->opacity_length_mm = 0.7;
  check("the opacity");
  scene.predicates.reset();
  check("without predicates");
  scene = test::random_predicate_scene(random, test::small_ultrasound(grid_of(2), 7), {});
  scene.predicates->model = test::model_of({{PredicateExpression::kind("intensity"), 1}});
  check("another volume");
}

TEST(PredicateCpuEngineTest, ANewUltrasoundImageTakesNoSample) {
  std::mt19937 random(8);
  const auto ct = test::small_ultrasound(grid_of(1), 1);
  const auto engine = make_cpu_engine();
  for (int i = 0; i < 10; ++i) {
    Scene scene = test::random_predicate_scene(random, ct, test::random_features(ct, 1));
    scene.plane = test::upright_plane(test::grey_image(20, 16, 120), 1, {0, 0, 8});
    scene.plane->opacity = 0.5;
    test::draw(*engine, scene);
    scene.plane->frame.pixels = test::grey_image(20, 16, 33);
    const RenderedImage live = test::draw(*engine, scene);
    EXPECT_EQ(live.statistics.volume_samples, 0U);
    EXPECT_LT(test::max_difference(live, test::draw(*make_reference_engine(), scene)), 0.05F);
    EXPECT_TRUE(test::same_bytes(live, test::draw(*make_cpu_engine(), scene)));
  }
}

}  // namespace
}  // namespace nav::render
