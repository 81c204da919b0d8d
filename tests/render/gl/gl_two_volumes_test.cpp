// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compares a CT with an ultrasound volume on the GL engine with the reference and with itself.

#include "tests/render/gl/gl_predicate_view.hpp"
#include "tests/render/predicates/two_volume_scenes.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

class GlTwoVolumesTest : public test::GlPredicateViewTest {};

constexpr int kViews = 4;

/// Scenes with all elements. There are few predicate sets, because each is compiled, and several
/// views of each from both sides. The ultrasound lies partly or completely outside of the CT. Every
/// second predicate set has a cutaway.
std::vector<Scene> random_pairs(unsigned seed, const std::vector<int>& volumes) {
  std::mt19937 random(seed);
  std::vector<Scene> all;
  for (const int i : volumes) {
    Scene scene = test::random_two(random, i);
    scene.cutaway.reset();
    if (all.size() / kViews % 2 == 1) {
      scene.cutaway.emplace();
      scene.cutaway->around_needle = scene.cutaway->around_spheres = true;
      scene.cutaway->overlay_mm = 4;
    }
    const Eigen::Vector3d aside(7, -4, 3);
    for (int view = 0; view < kViews; ++view) {
      const Eigen::Vector3d from = scene.camera.eye_ct.mm - scene.camera.look_at_ct.mm;
      scene.camera.eye_ct.mm =
          scene.camera.look_at_ct.mm + Eigen::Vector3d(from.y(), from.z(), from.x());
      scene.camera.orthographic = view % 2 == 1;
      scene.quality.step_voxels = 0.4 + 0.35 * view;
      scene.ultrasound->predicates.model.histogram.drag(0, 0.2 + 0.2 * view);
      all.push_back(scene);
      scene = test::moved_ct(scene, (view + 1) * aside);
    }
  }
  return all;
}

// Both checks are in one test, because each predicate set is compiled with and without skipping.
// The second one has a cutaway.
TEST_F(GlTwoVolumesTest, AgreesWithTheReferenceAndSkipsBitIdentically) {
  double beyond = 0;
  std::uint64_t with = 0;
  std::uint64_t without = 0;
  const std::vector<Scene> scenes = random_pairs(21, {0, 1});
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    Scene scene = scenes[i];
    const RenderedImage skipped = draw(scene);
    const RenderedImage expected = test::draw(*reference_, scene);
    const double share =
        test::difference(skipped.pixels, expected.pixels, test::kAgreement255).fraction_above;
    EXPECT_LT(share, 0.02) << i;
    beyond += share;
    if (i < kViews) continue;
    with += skipped.statistics.volume_samples;
    scene.quality.skip_empty_bricks = false;
    const RenderedImage full = draw(scene);
    without += full.statistics.volume_samples;
    ASSERT_TRUE(test::same_bytes(skipped, full))
        << i << ": " << test::max_difference(skipped, full);
  }
  EXPECT_LE(beyond, kShare * static_cast<double>(scenes.size()));
  EXPECT_LT(with, without) << "nothing was skipped";
}

TEST_F(GlTwoVolumesTest, EarlyTerminationStaysWithinItsError) {
  float worst = 0;
  std::uint64_t with = 0;
  std::uint64_t without = 0;
  for (Scene scene : random_pairs(8, {1})) {
    scene.ultrasound->predicates.opacity_length_mm = 0.15;
    scene.ultrasound->predicates.model =
        test::model_of({{PredicateExpression::kind("intensity", {0.1, 1}), 2},
                        {PredicateExpression::kind("depth", {4, 9}), 1}});
    scene.ultrasound->ct_importance = without > 0 ? 0.5 : 1024;
    const RenderedImage full = draw(scene);
    scene.ultrasound->predicates.termination_error = 1.0 / 255;
    const RenderedImage fast = draw(scene);
    worst = std::max(worst, test::max_difference(fast, full));
    with += fast.statistics.volume_samples;
    without += full.statistics.volume_samples;
  }
  EXPECT_LE(worst, 1.0F / 255 + 1e-5F);
  EXPECT_LT(with, without);
}

TEST_F(GlTwoVolumesTest, TwoMediaAtOnePositionMixWithSecondOrder) {
  Scene scene = test::fog_scene(test::centred_grid({31, 31, 31}, {1, 1, 1}), 0.08);
  const double grey = test::grey_tau();
  const double tau = 0.08 + grey;
  const double alpha = -std::expm1(-tau * 30);
  const double red = alpha * (0.08 * 1 + grey * test::kGrey) / tau;
  const double blue = alpha * (0.08 * 0.25 + grey * test::kGrey) / tau;
  for (const double step : {2.0, 1.0, 0.5, 0.25, 0.125}) {
    scene.quality.step_voxels = step;
    const RgbaF pixel = test::middle(draw(scene));
    const double error = std::max(std::abs(pixel.r - red), std::abs(pixel.b - blue));
    EXPECT_LT(error, 0.5 * 0.08 * grey * step * step + 2e-5) << step;
  }
}

TEST_F(GlTwoVolumesTest, MediaOutsideOfEachOtherAreInExactOrder) {
  for (const double y : {-25.0, 25.0}) {
    VoxelGrid thin = test::centred_grid({31, 9, 31}, {1, 0.5, 1});
    thin.origin_mm.y() += y;
    const Scene scene = test::fog_scene(thin, 0.05);
    const double fog = -std::expm1(-0.05 * 30);
    const double grey = -std::expm1(-test::grey_tau() * 4);
    const double expected =
        y < 0 ? grey * test::kGrey + (1 - grey) * fog : fog + (1 - fog) * grey * test::kGrey;
    EXPECT_NEAR(test::middle(draw(scene)).r, expected, 2e-5) << y;
  }
}

TEST_F(GlTwoVolumesTest, EitherVolumeMayBeInvisible) {
  Scene scene = test::fog_scene(test::centred_grid({21, 21, 21}, {0.7, 0.9, 0.8}), 0.1);
  scene.width = 40;
  scene.height = 30;
  const auto ultrasound = scene.ultrasound;
  scene.ultrasound->volume =
      test::make_volume(ultrasound->volume->grid(), [](int, int, int) { return 0; });
  const RenderedImage both = draw(scene);
  scene.ultrasound.reset();
  EXPECT_LT(test::max_difference(both, draw(scene)), 2e-5F);
  EXPECT_EQ(caster().second_uploads().volumes, 1);
  scene.ultrasound = ultrasound;
  scene.transfer = test::fog(0);
  EXPECT_LE(share_beyond(scene, 0.1), 0);
}

TEST_F(GlTwoVolumesTest, TheUltrasoundIsNotDrawnInProjections) {
  Scene scene = test::fog_scene(test::centred_grid({21, 21, 21}, {1, 1, 1}), 0.1);
  scene.projection = Projection::kMean;
  const RenderedImage both = draw(scene);
  scene.ultrasound.reset();
  EXPECT_TRUE(test::same_bytes(both, draw(scene)));
}

/// A model with \p count predicates.
PredicateModel many(std::size_t count) {
  std::vector<std::pair<PredicateExpression, double>> entries;
  for (std::size_t j = 0; j < count; ++j) {
    const double low = 0.6 * static_cast<double>(j) / static_cast<double>(count);
    entries.emplace_back(PredicateExpression::kind("intensity", {low, low + 0.3}),
                         1 + 0.3 * static_cast<double>(j % 5));
  }
  return test::model_of(std::move(entries));
}

TEST_F(GlTwoVolumesTest, DrawsOneToTheLargestNumberOfPredicates) {
  std::mt19937 random(4);
  Scene scene = test::random_two(random, 5);
  scene.cutaway.reset();
  for (const std::size_t count : {1U, 9U, 32U}) {
    scene.ultrasound->predicates.model = many(count);
    for (const double importance : {0.0, 1.0, 1024.0}) {
      scene.ultrasound->ct_importance = importance;
      EXPECT_LE(share_beyond(scene), kShare) << count << ' ' << importance;
    }
  }
}

TEST_F(GlTwoVolumesTest, ParameterEditsNeverCompileOrUploadVolumes) {
  std::mt19937 random(9);
  Scene scene = test::random_two(random, 2);
  scene.cutaway.reset();
  draw(scene);
  ASSERT_EQ(caster().compiled(), 1);
  UltrasoundVolume& ultrasound = *scene.ultrasound;
  const auto check = [&](const char* what) {
    EXPECT_LE(share_beyond(scene), 4 * kShare) << what;
    EXPECT_EQ(caster().compiled(), 1) << what;
  };
  ultrasound.ct_importance = 0.1;
  check("the CT's importance");
  ultrasound.predicates.model.histogram.drag(0, 0.9);
  ultrasound.predicates.opacity_length_mm = 0.7;
  check("a weight");
  scene.transfer = *preset_transfer_function("ct-soft-tissue");
  check("the transfer function");
  scene = test::moved_ct(scene, {3, 2, 1});
  check("another position");
  EXPECT_EQ(caster().second_uploads().volumes, 1);
}

TEST_F(GlTwoVolumesTest, ANewPredicateSetDoesNotWaitForTheCompilerInSoftware) {
  caster().set_in_software(true);
  caster().set_settled_after(GlRaycaster::kSettledAfter);
  Scene scene = test::fog_scene(test::centred_grid({15, 15, 15}, {1, 1, 1}), 0.05);
  draw(scene);
  ASSERT_EQ(caster().compiled(), 1);
  scene.ultrasound->predicates.model =
      test::model_of({{PredicateExpression::kind("target_distance", {0, 6}), 3},
                      {PredicateExpression::kind("intensity", {0.1, 1}), 1}});
  scene.spheres.push_back({{{4, 2, 0}}, 2, {1, 0.8, 0.1}, 0.5});
  draw(scene);
  EXPECT_EQ(caster().compiled(), 2) << "with solids";
  scene.ultrasound->predicates.model = test::model_of(
      {{PredicateExpression::negation(PredicateExpression::kind("target_distance", {0, 6})), 3}});
  EXPECT_LE(share_beyond(scene), kShare);
  EXPECT_EQ(caster().compiled(), 2);
}

TEST_F(GlTwoVolumesTest, DevicesCompileEachPredicateSetAtOnce) {
  caster().set_in_software(false);
  caster().set_settled_after(GlRaycaster::kSettledAfter);
  Scene scene = test::fog_scene(test::centred_grid({15, 15, 15}, {1, 1, 1}), 0.05);
  for (const double high : {0.5, 1.0}) {
    scene.ultrasound->predicates.model =
        test::model_of({{PredicateExpression::kind("intensity", {0.1, high}), 1}});
    EXPECT_LE(share_beyond(scene), kShare);
    EXPECT_EQ(caster().compiled(), 1) << "a limit is no other set";
  }
  scene.ultrasound->predicates.model =
      test::model_of({{PredicateExpression::kind("intensity", {0.1, 0.3}), 3},
                      {PredicateExpression::kind("intensity", {0.2, 1}), 1}});
  EXPECT_LE(share_beyond(scene), kShare);
  EXPECT_EQ(caster().compiled(), 2);
}

TEST_F(GlTwoVolumesTest, AMovedPlaneCastsOnlyTheRaysThatMeetIt) {
  Scene scene = test::fog_scene(test::centred_grid({21, 21, 21}, {1, 1, 1}), 0.05);
  scene.width = 48;
  scene.height = 36;
  scene.plane = test::upright_plane(test::grey_image(8, 8, 120), 0.5, {0, 0, 0});
  EXPECT_LE(share_beyond(scene), kShare);
  scene.plane->frame.pixels = test::grey_image(8, 8, 33);
  EXPECT_LE(share_beyond(scene), kShare);
  EXPECT_EQ(caster().statistics().volume_samples, 0U) << "a new image needs no sample";
  scene.plane->ct_from_image = {
      scene.plane->ct_from_image.rotation(),
      scene.plane->ct_from_image.translation_mm() + Eigen::Vector3d(0.5, 0, 0.25)};
  const auto moved = test::GlViewTest::draw(scene);
  EXPECT_GT(caster().statistics().rays, 0U);
  EXPECT_LT(caster().statistics().rays, 48U * 36U / 2);
  EXPECT_TRUE(test::same_bits(moved, draw_anew(scene)));
}

TEST_F(GlTwoVolumesTest, RejectsAnUltrasoundThatTheDeviceCannotHold) {
  const Scene scene = test::fog_scene(test::centred_grid({33, 9, 9}, {1, 1, 1}), 0.05);
  caster().set_largest_edge(32);
  const auto drawn = try_to_draw(scene);
  ASSERT_FALSE(drawn);
  EXPECT_TRUE(test::rejects(drawn, ErrorCode::kUnsupportedData,
                            {"predicates", "33 x 9 x 9 voxels", "CPU engine"}));
}

}  // namespace
}  // namespace nav::render
