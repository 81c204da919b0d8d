// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compares the step and pixel error for a requested error with converged images.
#include "render/quality/step_search.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "render/quality/ray_sparing.hpp"
#include "sim/synthetic_ct.hpp"
#include "tests/render/scene_support.hpp"
#include "tests/support/trials.hpp"

namespace nav::render {
namespace {

Scene abdomen(const char* preset, bool shaded) {
  static const auto ct = sim::SyntheticAbdomen::volume(64);
  Scene scene{.ct = ct, .transfer = *preset_transfer_function(preset)};
  scene.camera = {{{-180, -620, 160}}, {{0, 0, 0}}, {{0, 0, 1}}};
  scene.shading.enabled = shaded;
  scene.width = 320;
  scene.height = 240;
  return scene;
}

RenderedImage at_quality(Engine& engine, Scene scene, double step, double pixel_error) {
  scene.quality.step_voxels = step;
  scene.quality.pixel_error = pixel_error;
  return test::draw(engine, scene);
}

/// The whole image, converged.
RenderedImage truth_of(Engine& engine, Scene scene) {
  scene.quality.opaque_at = 1;
  return at_quality(engine, scene, 1.0 / 32, 0);
}

/// The work for an image. Gradients count as samples.
double work(const RenderedImage& image) {
  return static_cast<double>(image.statistics.volume_samples + image.statistics.gradient_samples);
}

TEST(StepSearchTest, TheErrorIsNearTheEstimateAndAtMostTheRequestedOne) {
  // True over estimated error of the whole image. The search uses a twentieth of it.
  constexpr double kLeast = 0.6;
  constexpr double kMost = 1.15;
  // The error of a coarser step must exceed the request. If it does not, the chosen step is too
  // fine.
  constexpr double kCoarser = 1.6;
  const auto engine = make_cpu_engine();
  for (const char* preset : test::trials({"ct-bone", "ct-soft-tissue", "cta-vessels"})) {
    for (const bool shaded : test::trials({false, true})) {
      const Scene scene = abdomen(preset, shaded);
      const RenderedImage truth = truth_of(*engine, scene);
      const auto error_at = [&](double step, double pixel_error) {
        const RenderedImage image = at_quality(*engine, scene, step, pixel_error);
        return rms_difference(image.pixels, truth.pixels);
      };
      for (const double asked : {1e-2, 4e-3, kDefaultRms}) {
        const auto choice = step_for_error(*make_cpu_engine(), scene, asked);
        ASSERT_TRUE(test::has_value(choice));
        const std::string where = std::string(preset) + (shaded ? ", shaded, " : ", ") +
                                  std::to_string(asked) + ", step " +
                                  std::to_string(choice->step_voxels) + ", pixel error " +
                                  std::to_string(choice->pixel_error);
        ASSERT_TRUE(choice->reached) << where;
        const double found = error_at(choice->step_voxels, choice->pixel_error);
        EXPECT_LE(found, asked) << where;
        EXPECT_LE(choice->rms, asked) << where;
        EXPECT_LE(found, kMost * choice->rms) << where;
        EXPECT_GE(found, kLeast * choice->rms) << where;
        if (choice->step_voxels >= 4) continue;
        EXPECT_GT(error_at(kCoarser * choice->step_voxels, choice->pixel_error), asked) << where;
      }
    }
  }
}

/// The error of an image as shown, against an image without rounding.
double shown_error(const Image2d<RgbaF>& image, const Image2d<RgbaF>& truth) {
  const Image2d<Rgba8> bytes = to_8bit(image);
  std::vector<RgbaF> shown;
  for (const Rgba8& p : bytes.pixels()) {
    shown.push_back({static_cast<float>(p.r) / 255, static_cast<float>(p.g) / 255,
                     static_cast<float>(p.b) / 255, 1});
  }
  return rms_difference({image.width(), image.height(), std::move(shown)}, truth);
}

TEST(StepSearchTest, EightBitImagesStayWithinTheRequestedError) {
  // Rounding alone has an error of 0.0011, most of this.
  constexpr double kAsked = 1.5e-3;
  const auto engine = make_cpu_engine();
  for (const bool shaded : test::trials({false, true})) {
    Scene scene = abdomen("ct-soft-tissue", shaded);
    scene.camera = {{{-50, -300, 40}}, {{0, 0, 0}}, {{0, 0, 1}}};  // Shows tissue only.
    const auto choice = step_for_error(*engine, scene, kAsked);
    ASSERT_TRUE(test::has_value(choice));
    EXPECT_TRUE(choice->reached);
    const RenderedImage truth = truth_of(*engine, scene);
    const RenderedImage image =
        at_quality(*engine, scene, choice->step_voxels, choice->pixel_error);
    const double found = shown_error(image.pixels, truth.pixels);
    EXPECT_LE(found, kAsked) << choice->step_voxels << ' ' << choice->pixel_error;
    EXPECT_NEAR(found, choice->rms, 0.15 * kAsked) << "estimated";
    EXPECT_GT(shown_error(truth.pixels, truth.pixels), 0.6 * kAsked) << "nothing is tested";
  }
}

TEST(StepSearchTest, ReportsThatEightBitsCannotReachTheError) {
  constexpr double kHalfLevel = 0.5 / 255;
  Scene scene = abdomen("ct-bone", false);
  scene.background_rgb.setConstant(100.5 / 255);  // A value that 8 bits cannot hold.
  const auto engine = make_cpu_engine();
  const auto choice = step_for_error(*engine, scene, kHalfLevel / 2);
  ASSERT_TRUE(test::has_value(choice));
  EXPECT_FALSE(choice->reached);
  EXPECT_GT(choice->rms, 0.8 * kHalfLevel);
  // No step can correct it. The search must not take a step that is much finer than the request
  // needs.
  scene.background_rgb.setZero();
  const auto dark = step_for_error(*engine, scene, kHalfLevel / 2);
  ASSERT_TRUE(test::has_value(dark));
  EXPECT_GT(choice->step_voxels, 0.3 * dark->step_voxels);
  scene.transfer =
      *TransferFunction::create("nothing", {{-1024, {0, 0, 0}, 0, 0}, {3000, {0, 0, 0}, 0, 0}});
  scene.background_rgb.setConstant(100.5 / 255);
  const auto empty = step_for_error(*engine, scene, kHalfLevel / 2);
  ASSERT_TRUE(test::has_value(empty));
  EXPECT_DOUBLE_EQ(empty->step_voxels, 4);
  EXPECT_FALSE(empty->reached);
  EXPECT_NEAR(empty->rms, kHalfLevel, 1e-5);
}

TEST(StepSearchTest, TheUncertaintyOfAMeanFollowsTheSpreadOfItsValues) {
  const std::vector<double> values{1, 3, 1, 3};
  const Estimate four = Estimate::of(values);
  EXPECT_DOUBLE_EQ(four.mean, 2);
  EXPECT_DOUBLE_EQ(four.deviation, std::sqrt(4.0 / 3 / 4));
  EXPECT_EQ(Estimate::of(std::vector<double>(5, 7.0)).deviation, 0);
  EXPECT_TRUE(std::isinf(Estimate::of(std::vector<double>{7}).deviation));
  EXPECT_TRUE(std::isinf(Estimate::of({}).deviation));
}

TEST(StepSearchTest, ErrorAndSavingOfSparseRaysMatchTheWholeImage) {
  constexpr double kError = 1.6;  // A factor.
  constexpr double kSamples = 0.15;
  const auto engine = make_cpu_engine();
  Scene scene = abdomen("ct-soft-tissue", false);
  scene.width *= 3;
  scene.height *= 3;  // The tiles use a sixtieth of it.
  const auto all = ray_sparings(*engine, scene, 0.5);
  ASSERT_TRUE(test::has_value(all));
  ASSERT_GE(all->size(), 2U);
  const RenderedImage dense = at_quality(*engine, scene, 0.5, 0);
  EXPECT_EQ(all->front().pixel_error, 0);
  for (const Sparing& one : *all) {
    if (one.pixel_error == 0) continue;
    const RenderedImage spared = at_quality(*engine, scene, 0.5, one.pixel_error);
    const double found = rms_difference(spared.pixels, dense.pixels);
    EXPECT_LT(std::sqrt(one.error.mean), kError * found) << one.pixel_error;
    EXPECT_GT(std::sqrt(one.error.mean), found / kError) << one.pixel_error;
    const double scattered = 1.2;  // The cost of a sample where rays lie apart.
    EXPECT_NEAR(one.cost.samples_at_one_voxel / all->front().cost.samples_at_one_voxel / scattered,
                work(spared) / work(dense), kSamples);
  }
  scene.quality.jitter = true;
  const auto jittered = ray_sparings(*engine, scene, 0.5);
  ASSERT_TRUE(test::has_value(jittered));
  EXPECT_TRUE(jittered->empty()) << "no ray may be spared, so nothing is drawn";
}

TEST(StepSearchTest, UsesFewerRaysOnlyIfThatIsLessWork) {
  constexpr double kSaves = 0.95;
  const auto engine = make_cpu_engine();
  int spared = 0;
  for (const char* preset : test::trials({"ct-bone", "ct-soft-tissue", "cta-vessels"})) {
    for (const double asked : test::trials({2e-2, 5e-3, kDefaultRms})) {
      Scene scene = abdomen(preset, false);
      scene.width *= 3;
      scene.height *= 3;
      const auto choice = step_for_error(*engine, scene, asked);
      ASSERT_TRUE(test::has_value(choice));
      if (choice->pixel_error == 0) continue;
      ++spared;
      EXPECT_LT(work(at_quality(*engine, scene, choice->step_voxels, choice->pixel_error)),
                kSaves * work(at_quality(*engine, scene, choice->step_voxels, 0)))
          << preset << ", " << asked;
      scene.quality.jitter = true;
      const auto jittered = step_for_error(*engine, scene, asked);
      ASSERT_TRUE(test::has_value(jittered));
      EXPECT_EQ(jittered->pixel_error, 0) << "their rays differ by intent";
    }
  }
  EXPECT_TRUE(spared > 0 || test::kSanitized);
}

TEST(StepSearchTest, FindsAStepForEachImageSizeAndError) {
  const auto engine = make_cpu_engine();
  Scene scene = abdomen("ct-soft-tissue", true);
  const auto huge = step_for_error(*engine, scene, 1);
  ASSERT_TRUE(test::has_value(huge));
  EXPECT_DOUBLE_EQ(huge->step_voxels, 4);
  EXPECT_TRUE(huge->reached);
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 300}, {300, 1}, {75, 50}}) {
    scene.width = width;
    scene.height = height;
    const auto choice = step_for_error(*engine, scene, kDefaultRms);
    ASSERT_TRUE(test::has_value(choice)) << width << ' ' << height;
    EXPECT_GE(choice->step_voxels, 0.0625);
    EXPECT_LE(choice->step_voxels, 4);
    if (width >= 75) continue;
    EXPECT_EQ(choice->pixel_error, 0) << width << ' ' << height;
  }
}

TEST(StepSearchTest, ReportsAnUnreachableError) {
  const auto choice = step_for_error(*make_cpu_engine(), abdomen("cta-vessels", true), 1e-7);
  ASSERT_TRUE(test::has_value(choice));
  EXPECT_FALSE(choice->reached);
  EXPECT_DOUBLE_EQ(choice->step_voxels, 0.0625);
  EXPECT_GT(choice->rms, 1e-7);
}

TEST(StepSearchTest, AnEmptyImageTakesTheCoarsestStep) {
  Scene scene = abdomen("ct-bone", false);
  scene.transfer =
      *TransferFunction::create("nothing", {{-1024, {0, 0, 0}, 0, 0}, {3000, {0, 0, 0}, 0, 0}});
  const auto choice = step_for_error(*make_cpu_engine(), scene, kDefaultRms);
  ASSERT_TRUE(test::has_value(choice));
  EXPECT_DOUBLE_EQ(choice->step_voxels, 4);
  EXPECT_EQ(choice->rms, 0);
}

TEST(StepSearchTest, AnObjectInFrontOfTheVolumeDoesNotHideItsError) {
  const Scene bare = abdomen("ct-soft-tissue", true);
  Scene covered = bare;
  covered.spheres.push_back({{{0, -150, 0}}, 140, {1, 1, 1}, 1});
  covered.cutaway = Cutaway{};
  const auto engine = make_cpu_engine();
  const auto one = step_for_error(*engine, bare, kDefaultRms);
  const auto other = step_for_error(*engine, covered, kDefaultRms);
  ASSERT_TRUE(test::has_value(one) && test::has_value(other));
  EXPECT_EQ(one->step_voxels, other->step_voxels);
  EXPECT_EQ(one->pixel_error, other->pixel_error);
  EXPECT_EQ(one->rms, other->rms);
}

TEST(StepSearchTest, TheErrorOfACutawayIsAtMostTheEstimate) {
  // True over estimated error of the whole image.
  constexpr double kMost = 1.2;
  const auto engine = make_cpu_engine();
  bool finer = false;
  for (const char* preset : test::trials({"ct-liver", "ct-soft-tissue"})) {
    for (const double overlay_mm : test::trials({0.0, 15.0})) {
      Scene scene = abdomen(preset, false);
      const auto bare = step_for_error(*engine, scene, kDefaultRms);
      scene.plane = test::upright_plane(test::grey_image(120, 120, 90), 1, {-60, -40, 60});
      scene.cutaway.emplace().overlay_mm = overlay_mm;
      const auto cut = step_for_error(*engine, scene, kDefaultRms);
      ASSERT_TRUE(test::has_value(bare) && test::has_value(cut));
      const RenderedImage truth = truth_of(*engine, scene);
      const double found = rms_difference(
          at_quality(*engine, scene, cut->step_voxels, cut->pixel_error).pixels, truth.pixels);
      EXPECT_LT(found, kMost * cut->rms) << preset << ", " << overlay_mm;
      EXPECT_LE(cut->step_voxels, bare->step_voxels);
      if (!finer) {
        const auto known = step_for_error(*engine, scene, kDefaultRms, *bare);
        ASSERT_TRUE(test::has_value(known));
        EXPECT_EQ(known->step_voxels, cut->step_voxels);
        EXPECT_EQ(known->rms, cut->rms);
      }
      finer = finer || cut->step_voxels < 0.9 * bare->step_voxels || cut->rms > 1.05 * bare->rms;
    }
  }
  EXPECT_TRUE(finer || test::kSanitized) << "the cutaway is the harder one in some of them";
}

TEST(StepSearchTest, RejectsAnInvalidError) {
  for (const double rms : {0.0, -1.0, 1.5, std::nan("")}) {
    const auto choice = step_for_error(*make_cpu_engine(), abdomen("ct-bone", true), rms);
    EXPECT_TRUE(test::rejects(choice, ErrorCode::kUsage, {"rms in (0, 1]"}));
  }
}

}  // namespace
}  // namespace nav::render
