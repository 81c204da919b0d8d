// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compares the predicates of the GL engine with the reference and with itself.

#include "tests/render/gl/gl_predicate_view.hpp"
#include "tests/render/predicates/predicate_scenes.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;

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

class GlPredicatesTest : public test::GlPredicateViewTest {
 protected:
  /// A volume with features, and a model of some predicates.
  Scene scene_with(PredicateModel model, int volume = 1) {
    const auto ct = test::small_ultrasound(grid_of(volume), 5);
    Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(80, 30, false));
    scene.width = 48;
    scene.height = 36;
    scene.needle = test::needle({2, -3, 1}, {9, -20, 4});
    scene.spheres.push_back({{{4, 2, 0}}, 2, {1, 0.8, 0.1}, 0.5});
    scene.predicates.emplace();
    scene.predicates->model = std::move(model);
    scene.predicates->features = test::random_features(ct, 3);
    scene.predicates->scan = FanScan{{{0, -40, 0}}, 20};
    scene.predicates->termination_error = 0;
    EXPECT_TRUE(test::has_value(test::add_features(ct, 0.4, *scene.predicates)));
    return scene;
  }
};

/// Scenes with all elements that predicates may ask for. There are few predicate sets, because each
/// is compiled, and several views of each.
std::vector<Scene> random_scenes(unsigned seed, const std::vector<int>& volumes) {
  std::mt19937 random(seed);
  std::vector<Scene> all;
  for (const int i : volumes) {
    const auto ct = test::small_ultrasound(grid_of(i), static_cast<unsigned>(i));
    Scene scene = test::random_predicate_scene(random, ct,
                                               test::random_features(ct, static_cast<unsigned>(i)));
    for (int view = 0; view < 3; ++view) {
      const Eigen::Vector3d from = scene.camera.eye_ct.mm - scene.camera.look_at_ct.mm;
      scene.camera.eye_ct.mm =
          scene.camera.look_at_ct.mm + Eigen::Vector3d(from.y(), from.z(), from.x());
      scene.quality.step_voxels = 0.5 + 0.45 * view;
      scene.predicates->model.histogram.drag(0, 0.2 + 0.3 * view);
      all.push_back(scene);
    }
  }
  return all;
}

TEST_F(GlPredicatesTest, AgreesWithTheReferenceOnRandomScenes) {
  double beyond = 0;
  const std::vector<Scene> scenes = random_scenes(11, {0, 1, 3, 6});
  for (Scene scene : scenes) {
    scene.predicates->termination_error = 0;
    const double share = share_beyond(scene);
    EXPECT_LT(share, 0.02);
    beyond += share;
  }
  EXPECT_LE(beyond, kShare * static_cast<double>(scenes.size()));
}

TEST_F(GlPredicatesTest, SkippingGivesBitIdenticalImages) {
  std::uint64_t with = 0;
  std::uint64_t without = 0;
  int i = 0;
  for (Scene scene : random_scenes(2, {1, 6})) {
    if (++i % 3 == 0) scene.predicates->termination_error = 0;
    if (i % 3 == 1) scene.predicates->opacity_length_mm = 0.2;
    // The cutaway hides whole bricks whose material is not most important.
    if (i % 2 == 0) scene.predicates->cutaway_importance = 0.5;
    const RenderedImage skipped = draw(scene);
    scene.quality.skip_empty_bricks = false;
    const RenderedImage full = draw(scene);
    ASSERT_TRUE(test::same_bytes(skipped, full))
        << i << ": " << test::max_difference(skipped, full);
    with += skipped.statistics.volume_samples;
    without += full.statistics.volume_samples;
  }
  EXPECT_LT(with, without) << "nothing was skipped";
}

TEST_F(GlPredicatesTest, EarlyTerminationStaysWithinItsError) {
  std::uint64_t with = 0;
  std::uint64_t without = 0;
  float worst = 0;
  for (Scene scene : random_scenes(5, {0, 1})) {
    scene.predicates->opacity_length_mm = 0.15;
    const RenderedImage fast = draw(scene);
    scene.predicates->termination_error = 0;
    const RenderedImage full = draw(scene);
    worst = std::max(worst, test::max_difference(fast, full));
    with += fast.statistics.volume_samples;
    without += full.statistics.volume_samples;
  }
  EXPECT_LE(worst, 1.0F / 255 + 1e-5F);
  EXPECT_LT(with, without * 9 / 10) << "nothing was left out";
}

TEST_F(GlPredicatesTest, LayersOfNearlyEqualImportanceStayWithinTheirError) {
  test::expect_layers_within_error([&](const Scene& scene) { return draw(scene); });
}

/// A model with \p count entries. Each is a separate range of intensities.
PredicateModel many(std::size_t count, const std::function<double(std::size_t)>& importance) {
  std::vector<std::pair<E, double>> entries;
  for (std::size_t j = 0; j < count; ++j) {
    const double low = static_cast<double>(j) / static_cast<double>(count);
    entries.emplace_back(E::kind("intensity", {0.6 * low, 0.6 * low + 0.3}), importance(j));
  }
  return test::model_of(std::move(entries));
}

TEST_F(GlPredicatesTest, DrawsTheLargestNumberOfPredicates) {
  Scene scene =
      scene_with(many(32, [](std::size_t j) { return 1.0 + 0.3 * static_cast<double>(j % 5); }));
  EXPECT_LE(share_beyond(scene), kShare);
  scene.predicates->hue_mean = spec::HueMean::kLinear;
  EXPECT_LE(share_beyond(scene), kShare);
  EXPECT_EQ(caster().compiled(), 1);
}

TEST_F(GlPredicatesTest, TheFirstOfTwoOppositeHuesCounts) {
  for (const std::size_t count : {2U, 32U}) {
    std::vector<std::pair<E, double>> entries(2, {E::kind("intensity", {-1, 2}), 1});
    while (entries.size() < count) {  // Never true, and all different, so that they do not fit into
                                      // a table.
      entries.push_back({E::kind("intensity", {7, 8.0 + static_cast<double>(entries.size())}), 1});
    }
    Scene scene = scene_with(test::model_of(std::move(entries)));
    scene.predicates->model.histogram.set_colour(0, 20, 0.8);
    scene.predicates->model.histogram.set_colour(1, 200, 0.8);
    EXPECT_LE(share_beyond(scene, test::kAgreement255), kShare) << count;
  }
}

TEST_F(GlPredicatesTest, OnePredicateMayHaveAllImportance) {
  for (const std::size_t n : {3U, 9U, 32U}) {
    Scene scene = scene_with(many(n, [](std::size_t j) { return j == 1 ? 1.0 : 0.0; }));
    EXPECT_LE(share_beyond(scene), kShare) << n;
  }
}

TEST_F(GlPredicatesTest, VoxelsWithoutATruePredicateAreNotDrawn) {
  Scene scene = scene_with(test::model_of({{E::kind("intensity", {7, 8}), 1}}));
  scene.needle.reset();
  scene.spheres.clear();
  const RenderedImage image = draw(scene);
  const auto background = static_cast<float>(scene.background_rgb.x());
  for (const RgbaF& p : image.pixels.pixels()) EXPECT_FLOAT_EQ(p.r, background);
  EXPECT_EQ(image.statistics.volume_samples, 0U);
}

TEST_F(GlPredicatesTest, EqualImportancesCompositeWithPlainOver) {
  Scene scene = scene_with(test::model_of({{E::kind("snr", {0.1, 0.7}), 1},
                                           {E::kind("vesselness", {0.3, 1}), 1},
                                           {E::kind("intensity", {0.1, 1}), 1}}));
  EXPECT_LE(share_beyond(scene), kShare);
  const int compiled = caster().compiled();
  scene.predicates->model.histogram.drag(0, 0.5);
  EXPECT_LE(share_beyond(scene), kShare);
  EXPECT_EQ(caster().compiled(), compiled);
}

TEST_F(GlPredicatesTest, ASaturatedVolumeIsWithinClosedRanges) {
  Scene scene = scene_with(test::model_of({{E::kind("intensity", {1, 1}), 1}}));
  scene.ct = test::make_volume(scene.ct->grid(), [](int, int, int) { return 255.0; });
  EXPECT_LE(share_beyond(scene), kShare);
  EXPECT_GT(caster().statistics().bricks_occupied, 0U);
}

TEST_F(GlPredicatesTest, ParameterEditsNeverCompile) {
  PredicateModel model = test::model_of(
      {{E::all({E::kind("snr", {0.2, 0.9}), E::negation(E::kind("label", {1}))}), 3},
       {E::kind("gradient_angle", {0.1, 1.2, 0.003}), 2},
       {E::any({E::kind("needle_distance", {-1, 5}), E::kind("depth", {2, 9})}), 1}});
  Scene scene = scene_with(std::move(model));
  scene.cutaway.emplace();
  scene.cutaway->around_needle = true;
  draw(scene);
  ASSERT_EQ(caster().compiled(), 1);
  PredicateScene& p = *scene.predicates;
  p.model.histogram.drag(0, 0.9);
  p.model.histogram.set_colour(1, 300, 0.9);
  p.model.entries[0].expression.operands[0].values = {0.4, 0.5};
  p.model.entries[0].expression.operands[1].operands[0].values = {2147483648.0};
  p.model.entries[1].expression.values = {0, 2, 0.01};
  p.model.entries[2].expression.operands[1].values = {1, 3};
  p.hue_mean = spec::HueMean::kLinear;
  p.opacity_length_mm = 0.7;
  p.termination_error = 0.01;
  p.intensity = {10, 200};
  p.cutaway_importance = 0.9;
  p.scan = FanScan{{{0, -50, 0}}, 25};
  scene.needle->tip_ct.mm.x() += 3;
  scene.quality.skip_empty_bricks = false;
  draw(scene);
  // The combination of the predicates is a table as well, as long as the predicates themselves
  // stay.
  p.model.entries[0].expression.op = PredicateExpression::Operator::kOr;
  draw(scene);
  EXPECT_EQ(caster().compiled(), 1);
  p.termination_error = 0;
  EXPECT_LE(share_beyond(scene), kShare);
}

TEST_F(GlPredicatesTest, FeaturesAreUploadedOnce) {
  Scene scene = scene_with(test::model_of({{E::kind("snr", {0.1, 0.7}), 1}}));
  draw(scene);
  const int first = caster().predicates().features().uploads();
  scene.predicates->model = test::model_of({{E::kind("vesselness", {0.1, 0.7}), 1}});
  draw(scene);
  const int both = caster().predicates().features().uploads();
  EXPECT_GT(both, first);
  scene.predicates->model = test::model_of({{E::kind("snr", {0.2, 0.7}), 1}});
  EXPECT_LE(share_beyond(scene), kShare);
  EXPECT_EQ(caster().predicates().features().uploads(), both);
  EXPECT_EQ(caster().uploads().volumes, 1);
  EXPECT_EQ(caster().uploads().transfers, 0) << "nothing reads the transfer function";
}

TEST_F(GlPredicatesTest, FeaturesInSeveralSlabsAgreeWithTheReference) {
  std::mt19937 random(4);
  const auto ct = test::small_ultrasound(test::centred_grid({100, 90, 80}, {0.4, 0.4, 0.4}), 3);
  Scene scene = test::random_predicate_scene(random, ct, test::random_features(ct, 3));
  // The views are along the normal of the slices and from the side.
  for (int view = 0; view < 2; ++view) {
    EXPECT_LT(share_beyond(scene), 0.02) << view;
    const Eigen::Vector3d from = scene.camera.eye_ct.mm - scene.camera.look_at_ct.mm;
    scene.camera.eye_ct.mm =
        scene.camera.look_at_ct.mm + Eigen::Vector3d(from.y(), from.z(), from.x());
  }
}

TEST_F(GlPredicatesTest, CachesFollowEveryEdit) {
  std::mt19937 random(6);
  Scene scene = scene_with(test::random_model(random));
  const auto check = [&](const char* what) { EXPECT_LE(share_beyond(scene), 4 * kShare) << what; };
  check("first");
  scene.predicates->model.histogram.drag(0, 0.3);
  check("an importance");
  scene.predicates->features = test::random_features(scene.ct, 9);
  EXPECT_TRUE(test::has_value(test::add_features(scene.ct, 0.4, *scene.predicates)));
  check("other features");
  scene.predicates->model = test::random_model(random);
  EXPECT_TRUE(test::has_value(test::add_features(scene.ct, 0.4, *scene.predicates)));
  check("another set");
  scene.predicates->intensity.white = 180;
  check("the window");
  scene.predicates.reset();
  check("without predicates");
  scene = scene_with(test::random_model(random), 2);
  check("another volume");
  caster().release();
  scene.camera.eye_ct.mm.x() += 1;
  check("another context");
}

TEST_F(GlPredicatesTest, ANewUltrasoundImageTakesNoSample) {
  Scene scene = scene_with(
      test::model_of({{E::kind("vesselness", {0.4, 1}), 3}, {E::kind("intensity", {0.1, 1}), 1}}));
  scene.plane = test::upright_plane(test::grey_image(20, 16, 120), 1, {0, 0, 0});
  scene.plane->opacity = 0.5;
  EXPECT_LE(share_beyond(scene), kShare);
  scene.plane->frame.pixels = test::grey_image(20, 16, 33);
  EXPECT_LE(share_beyond(scene), kShare);
  EXPECT_EQ(caster().statistics().volume_samples, 0U);
}

/// Both programs compute the same numbers. Only the order of the operations differs.
constexpr double kGenericAgreement255 = 0.02;

TEST_F(GlPredicatesTest, TheGenericProgramGivesTheSameImage) {
  std::vector<Scene> scenes = random_scenes(11, {0, 3});
  scenes.push_back(scene_with(many(32, [](std::size_t j) { return 1.0 + double(j % 5); })));
  scenes.push_back(scene_with(test::model_of(
      {{E::all({E::kind("snr", {0.2, 0.9}), E::negation(E::kind("label", {1}))}), 3},
       {E::kind("gradient_angle", {0.1, 1.2, 0.003}), 2},
       {E::any({E::kind("needle_distance", {-1, 5}), E::kind("depth", {2, 9})}), 1}})));
  caster().set_settled_after(1000);  // Never settled.
  std::vector<RenderedImage> generic;
  for (const Scene& scene : scenes) {
    generic.push_back(draw(scene));
    Scene brute = scene;
    brute.quality.skip_empty_bricks = false;
    EXPECT_TRUE(test::same_bytes(generic.back(), draw(brute)));
  }
  caster().set_settled_after(0);
  double beyond = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const RenderedImage own = draw(scenes[i]);
    const auto found = test::difference(generic[i].pixels, own.pixels, kGenericAgreement255);
    EXPECT_LT(found.fraction_above, 0.02);
    beyond += found.fraction_above;
  }
  EXPECT_LE(beyond, kShare * static_cast<double>(scenes.size()));
}

TEST_F(GlPredicatesTest, ANewPredicateSetDoesNotWaitForTheCompiler) {
  caster().set_settled_after(GlRaycaster::kSettledAfter);
  Scene scene = scene_with(
      test::model_of({{E::kind("vesselness", {0.4, 1}), 3}, {E::kind("intensity", {0.1, 1}), 1}}));
  const auto draw_moved = [&] {
    scene.camera.eye_ct.mm.x() += 1;
    draw(scene);
    return caster().compiled();
  };
  EXPECT_EQ(draw_moved(), 1);
  for (int i = 1; i < GlRaycaster::kSettledAfter; ++i) EXPECT_EQ(draw_moved(), 1) << i;
  EXPECT_EQ(draw_moved(), 2) << "its own";
  for (const double low : {0.1, 0.2, 0.3}) {
    // Another kind of leaf each time, and therefore another program.
    scene.predicates->model = test::model_of(
        {{E::kind(low < 0.25 ? "snr" : "confidence", {low, 0.9}), 2},
         {E::negation(E::kind(low < 0.15 ? "needle_distance" : "depth", {-1, 5})), 1}});
    EXPECT_EQ(draw_moved(), 2) << low;
    EXPECT_LE(share_beyond(scene), kShare);
  }
  scene.predicates->model = test::model_of({{E::kind("snr", {0.1, 0.9}), 1}});
  for (int i = 0; i < GlRaycaster::kSettledAfter; ++i) EXPECT_EQ(draw_moved(), 2) << i;
  EXPECT_EQ(draw_moved(), 3);
}

/// Labels with the bits of `used`, one after the other along the volume.
LabelVolume labels_of(const StoredVolume& ct, const std::vector<std::uint32_t>& used) {
  std::vector<std::uint32_t> bits(ct.grid().voxel_count());
  for (std::size_t i = 0; i < bits.size(); ++i) bits[i] = used[i * used.size() / bits.size()];
  return *LabelVolume::create(ct.grid(), std::move(bits), "labels");
}

TEST_F(GlPredicatesTest, LabelsWithAnyBitsUseOneProgram) {
  const double mask = 2147483648.0;
  Scene scene = scene_with(test::model_of({{E::kind("label", {2 + mask}), 1}}));
  const std::uint32_t top = 1U << 31;
  std::vector<int> formats;
  for (const std::vector<std::uint32_t>& used :
       {std::vector<std::uint32_t>{1, 2, 3}, {1, 2, 1U << 9}, {4, top, 2 + top}, {4, 1U << 20}}) {
    scene.predicates->features.labels = labels_of(*scene.ct, used);
    EXPECT_LE(share_beyond(scene), kShare);
    formats.push_back(caster().predicates().label_format());
  }
  EXPECT_EQ(formats, std::vector<int>(4, formats[0]));
  scene.camera.eye_ct.mm.x() += 1;
  caster().set_settled_after(1000);
  scene.predicates->model =
      test::model_of({{E::kind("label", {2 + mask}), 1}, {E::kind("depth", {-9, 1e4}), 0}});
  EXPECT_LE(share_beyond(scene), kShare) << "the generic program";
  scene.predicates->features.labels =
      labels_of(*scene.ct, {1, 2, 4, 8, 16, 32, 64, 128, 1U << 30, 0x3FF00U, top});
  EXPECT_LE(share_beyond(scene), kShare) << "more bits than a texel has";
  EXPECT_NE(caster().predicates().label_format(), formats[0]);
}

TEST_F(GlPredicatesTest, TooFewTexturesAreReportedBeforeCompiling) {
  Scene scene = scene_with(
      test::model_of({{E::kind("vesselness", {0.4, 1}), 3}, {E::kind("intensity", {0.1, 1}), 1}}));
  caster().set_settled_after(1000);
  caster().set_most_samplers(8);  // Its own program fits, but the generic one does not.
  EXPECT_LE(share_beyond(scene), kShare);
  const int compiled = caster().compiled();
  scene.predicates->model = test::model_of({{E::kind("snr", {0.1, 0.9}), 1}});
  caster().set_most_samplers(5);
  const auto drawn = try_to_draw(scene);
  ASSERT_FALSE(drawn);
  EXPECT_EQ(drawn.error().message,
            "OpenGL: expected at least 7 textures in a fragment shader for this scene, found "
            "GL_MAX_TEXTURE_IMAGE_UNITS 5; the CPU engine draws it");
  EXPECT_EQ(caster().compiled(), compiled);
}

TEST_F(GlPredicatesTest, AMovedPlaneCastsOnlyTheRaysThatMeetIt) {
  Scene scene = scene_with(
      test::model_of({{E::kind("vesselness", {0.4, 1}), 3}, {E::kind("intensity", {0.1, 1}), 1}}));
  scene.plane = test::upright_plane(test::grey_image(20, 16, 120), 0.5, {0, 0, 0});
  draw(scene);
  scene.plane->ct_from_image = {
      scene.plane->ct_from_image.rotation(),
      scene.plane->ct_from_image.translation_mm() + Eigen::Vector3d(0.5, 0, 0.25)};
  const auto moved = test::GlViewTest::draw(scene);
  EXPECT_GT(caster().statistics().rays, 0U);
  EXPECT_LT(caster().statistics().rays, 48U * 36U / 2);
  EXPECT_TRUE(test::same_bits(moved, draw_anew(scene)));
}

TEST_F(GlPredicatesTest, AMovedNeedleOfADistancePredicateCastsAllRays) {
  Scene scene = scene_with(test::model_of(
      {{E::kind("needle_distance", {0, 6}), 3}, {E::kind("intensity", {0.1, 1}), 1}}));
  draw(scene);
  scene.needle->tip_ct.mm.x() += 1;
  const auto moved = test::GlViewTest::draw(scene);
  EXPECT_EQ(caster().statistics().rays, 48U * 36U);
  EXPECT_TRUE(test::same_bits(moved, draw_anew(scene)));
}

TEST_F(GlPredicatesTest, RejectsAVolumeThatTheDeviceCannotHold) {
  const Scene scene = scene_with(test::model_of({{E::kind("intensity", {0.1, 1}), 1}}));
  caster().set_largest_edge(16);
  const auto drawn = try_to_draw(scene);
  ASSERT_FALSE(drawn);
  EXPECT_TRUE(test::rejects(drawn, ErrorCode::kUnsupportedData,
                            {"predicates", "29 x 26 x 25 voxels", "CPU engine"}));
}

}  // namespace
}  // namespace nav::render
