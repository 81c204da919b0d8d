// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/image_registration.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "registration/acceptance.hpp"
#include "registration/prepared.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/trials.hpp"

namespace nav::registration {
namespace {

using test::BlobPatient;

constexpr double kStartMm = 10;
constexpr double kStartRad = 8 * M_PI / 180;
// A quarter of a 2 mm voxel, for a patient that follows the model with noise of 4 grey levels.
constexpr double kSameAnswerMm = 0.05;
constexpr double kToleranceMm = 0.5;

/// One patient for all tests, because the computation of the images is slow.
struct Scene {
  BlobPatient patient{11};
  Volume ct = test::blob_ct(patient, test::cubic_grid());
  Sweep sweep = test::blob_sweep(patient, {});
};
const Scene& scene() {
  static const Scene instance;
  return instance;
}

/// With a well-known calibration: these few parallel images do not show it.
ImageRegistrationOptions calibrated_options() {
  ImageRegistrationOptions options = test::small_options(60);
  options.calibration_sigma_mm = 0.2;
  return options;
}

Result<ImageRegistrationResult> solve(
    const Transform<frames::Ct, frames::Reference>& start,
    const ImageRegistrationOptions& options = calibrated_options()) {
  CollectingDiagnostics diagnostics;
  return register_sweep(scene().ct, scene().sweep, start, options, diagnostics);
}

TEST(ImageRegistrationTest, FindsTheTruePoseFromSeveralStarts) {
  for (unsigned seed = 1; seed <= test::trials(4U); ++seed) {
    const auto result = solve(test::off_by(test::true_pose(), kStartMm, kStartRad, seed));
    ASSERT_TRUE(test::has_value(result));
    EXPECT_LT(test::cube_error_mm(result->ct_from_reference, test::true_pose()), kToleranceMm)
        << "start " << seed;
    EXPECT_LT(result->final_cost, result->initial_cost);
    const Decision decision = decide(*result, {}, {{0, 0, 0}});
    EXPECT_TRUE(decision.accepted) << (decision.reasons.empty() ? "" : decision.reasons[0]);
  }
}

TEST(ImageRegistrationTest, TheSearchFindsThePoseWhereThePlainSolveFails) {
  const auto start = test::off_by(test::true_pose(), 30, 0.4, 1);
  auto options = test::small_options(60);
  options.starts = 0;
  const auto plain = solve(start, options);
  ASSERT_TRUE(test::has_value(plain));
  EXPECT_GT(test::cube_error_mm(plain->ct_from_reference, test::true_pose()), 5.0);
  options.starts = 600;
  const auto searched = solve(start, options);
  ASSERT_TRUE(test::has_value(searched));
  EXPECT_LT(test::cube_error_mm(searched->ct_from_reference, test::true_pose()), kToleranceMm);
  ASSERT_TRUE(searched->margin.has_value());  // Margin to the pose at which the plain solve ended.
  EXPECT_GT(*searched->margin, 0.15);
}

TEST(ImageRegistrationTest, PreparedDataGiveTheSameResultFromEveryStart) {
  auto options = test::small_options(60);
  options.starts = 0;
  CollectingDiagnostics diagnostics;
  const auto ct = PreparedCt::create(scene().ct, options);
  const auto sweep = PreparedSweep::create(scene().sweep, options, diagnostics);
  ASSERT_TRUE(test::has_value(ct));
  ASSERT_TRUE(test::has_value(sweep));
  for (unsigned seed = 1; seed <= test::trials(3U); ++seed) {
    const auto start = test::off_by(test::true_pose(), 5, 0.05, seed);
    const auto result = register_prepared(*ct, *sweep, start, options);
    ASSERT_TRUE(test::has_value(result));
    EXPECT_LT(test::cube_error_mm(result->ct_from_reference, test::true_pose()), kToleranceMm);
    // Here the CT is prepared only near the poses of each level, so the texels of coarse levels lie
    // elsewhere.
    const auto once = register_prepared(scene().ct, *sweep, start, options);
    ASSERT_TRUE(test::has_value(once));
    EXPECT_LT(test::cube_error_mm(once->ct_from_reference, result->ct_from_reference),
              kSameAnswerMm);
    EXPECT_NEAR(once->final_cost, result->final_cost, 0.01);
    EXPECT_NEAR(once->initial_cost, result->initial_cost, 0.01);
  }
}

TEST(ImageRegistrationTest, OneAndTwoThreadsGiveEqualBits) {
  const auto start = test::off_by(test::true_pose(), kStartMm, kStartRad, 1);
  auto options = test::small_options(60);
  const auto one = solve(start, options);
  options.threads = 2;
  const auto two = solve(start, options);
  ASSERT_TRUE(test::has_value(one));
  ASSERT_TRUE(test::has_value(two));
  EXPECT_EQ(one->ct_from_reference.matrix(), two->ct_from_reference.matrix());
  EXPECT_EQ(one->final_cost, two->final_cost);
  EXPECT_EQ(one->z_score, two->z_score);
  EXPECT_EQ(one->uncertainty.covariance, two->uncertainty.covariance);
  EXPECT_EQ(one->split_disagreement_mm, two->split_disagreement_mm);
}

TEST(ImageRegistrationTest, DistantOriginsDoNotMatter) {
  const Eigen::Vector3d ct_offset(1e4, -1e4, 1e4);
  const Eigen::Vector3d reference_offset(-1e4, 1e4, 5e3);
  const Volume ct = test::blob_ct(scene().patient, test::cubic_grid(), ct_offset);
  const Sweep sweep = test::blob_sweep(scene().patient, {}, ct_offset, reference_offset);
  auto truth = test::true_pose(ct_offset);
  truth = {truth.rotation(), truth.translation_mm() - truth.rotation() * reference_offset};
  CollectingDiagnostics diagnostics;
  const auto far = register_sweep(ct, sweep, test::off_by(truth, 5, 0.05, 1, ct_offset),
                                  test::small_options(60), diagnostics);
  const auto near = solve(test::off_by(test::true_pose(), 5, 0.05, 1));
  ASSERT_TRUE(test::has_value(far));
  ASSERT_TRUE(test::has_value(near));
  // The arithmetic differs in the last bits of 1e4 mm. The solver stops at about 1 µm.
  constexpr double kSolverMm = 0.01;
  EXPECT_NEAR(test::cube_error_mm(far->ct_from_reference, truth, ct_offset),
              test::cube_error_mm(near->ct_from_reference, test::true_pose()), kSolverMm);
}

TEST(ImageRegistrationTest, GainAndOffsetOfTheUltrasoundDoNotMatter) {
  test::SweepSpec dim;
  dim.gain *= 0.6;
  dim.offset = 80;
  dim.echo *= 0.6;
  dim.noise *= 0.6;
  const Sweep sweep = test::blob_sweep(scene().patient, dim);
  CollectingDiagnostics diagnostics;
  const auto start = test::off_by(test::true_pose(), 5, 0.05, 1);
  const auto result =
      register_sweep(scene().ct, sweep, start, test::small_options(60), diagnostics);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_LT(test::cube_error_mm(result->ct_from_reference, test::true_pose()), kToleranceMm);
}

TEST(ImageRegistrationTest, RejectsAnotherPatient) {
  const Volume other = test::blob_ct(BlobPatient(99), test::cubic_grid());
  CollectingDiagnostics diagnostics;
  const auto result =
      register_sweep(other, scene().sweep, test::true_pose(), test::small_options(60), diagnostics);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_FALSE(decide(*result, {}, {{0, 0, 0}}).accepted);
}

TEST(ImageRegistrationTest, RejectsAMirroredCt) {
  std::vector<std::int16_t> hu(scene().ct.hu().begin(), scene().ct.hu().end());
  const auto row = static_cast<std::ptrdiff_t>(scene().ct.grid().size[0]);
  for (auto at = hu.begin(); at != hu.end(); at += row) std::reverse(at, at + row);
  const auto mirrored = Volume::create(scene().ct.grid(), std::move(hu), "mirrored");
  ASSERT_TRUE(test::has_value(mirrored));
  CollectingDiagnostics diagnostics;
  const auto result = register_sweep(*mirrored, scene().sweep, test::true_pose(),
                                     test::small_options(60), diagnostics);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_FALSE(decide(*result, {}, {{0, 0, 0}}).accepted);
}

TEST(ImageRegistrationTest, RejectsHopelessStarts) {
  for (unsigned seed = 1; seed <= test::trials(2U); ++seed) {
    const auto result = solve(test::off_by(test::true_pose(), 50, 1.2, seed));
    if (!result) {
      EXPECT_EQ(result.error().code, ErrorCode::kRefused) << result.error().message;
      continue;
    }
    if (test::cube_error_mm(result->ct_from_reference, test::true_pose()) < 2) continue;
    EXPECT_FALSE(decide(*result, {}, {{0, 0, 0}}).accepted) << seed;
  }
}

TEST(ImageRegistrationTest, AConstantCtIsNeverAccepted) {
  const VoxelGrid grid = test::cubic_grid();
  const auto flat = Volume::create(grid, std::vector<std::int16_t>(grid.voxel_count(), 40), "flat");
  ASSERT_TRUE(test::has_value(flat));
  CollectingDiagnostics diagnostics;
  const auto result =
      register_sweep(*flat, scene().sweep, test::true_pose(), test::small_options(60), diagnostics);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_NEAR(result->final_cost, 1.0, 1e-4);  // The CT explains nothing. This is not a perfect
                                               // match.
  EXPECT_FALSE(result->covariance_valid);
  EXPECT_FALSE(decide(*result, {}, {{0, 0, 0}}).accepted);
}

TEST(ImageRegistrationTest, ExtremeHuValuesGiveAFiniteResult) {
  std::vector<std::int16_t> hu(scene().ct.hu().begin(), scene().ct.hu().end());
  for (std::size_t i = 0; i < hu.size(); i += 5000) hu[i] = i % 2 == 0 ? 32767 : -32768;
  const auto metal = Volume::create(scene().ct.grid(), std::move(hu), "metal");
  CollectingDiagnostics diagnostics;
  const auto start = test::off_by(test::true_pose(), 5, 0.05, 1);
  const auto result =
      register_sweep(*metal, scene().sweep, start, test::small_options(60), diagnostics);
  ASSERT_TRUE(test::has_value(result));
  // One voxel in 5000 is wrong by the whole HU window.
  constexpr double kMetalMm = 1.0;
  EXPECT_LT(test::cube_error_mm(result->ct_from_reference, test::true_pose()), kMetalMm);
}

TEST(ImageRegistrationTest, RejectsASweepOutsideTheCt) {
  const auto truth = test::true_pose();
  const Transform<frames::Ct, frames::Reference> away(
      truth.rotation(), truth.translation_mm() + Eigen::Vector3d(2000, 0, 0));
  EXPECT_TRUE(test::rejects(solve(away), ErrorCode::kRefused, {"blob patient", "outside"}));
}

TEST(ImageRegistrationTest, RejectsImagesWithoutEchoes) {
  test::SweepSpec dark;
  dark.frames = 4;
  dark.gain = dark.offset = dark.echo = dark.noise = 0;
  const Sweep sweep = test::blob_sweep(scene().patient, dark);
  CollectingDiagnostics diagnostics;
  EXPECT_TRUE(test::rejects(
      register_sweep(scene().ct, sweep, test::true_pose(), test::small_options(60), diagnostics),
      ErrorCode::kRefused,
      {"patches outside shadows, found 0", "0 of 4 images", "4 are of one grey", "110 x 110 mm",
       "6.4 x 6.4 mm", "the first 10 mm"}));
}

TEST(ImageRegistrationTest, ReportsThatAPatchDoesNotFitIntoTheImages) {
  std::vector<TrackedImage> frames = scene().sweep.frames();
  for (TrackedImage& tracked : frames) tracked.frame.grid = PixelGrid::centred(110, 0.01, 0.02);
  const auto tiny = Sweep::create(std::move(frames), "wrong pixels");
  ASSERT_TRUE(test::has_value(tiny));
  CollectingDiagnostics diagnostics;
  EXPECT_TRUE(test::rejects(
      register_sweep(scene().ct, *tiny, test::true_pose(), test::small_options(60), diagnostics),
      ErrorCode::kRefused, {"0 are of one grey", "1.1 x 2.2 mm", "6.4 x 6.4"}));
}

TEST(ImageRegistrationTest, OneImageIsNeverAccepted) {
  test::SweepSpec single;
  single.frames = 1;
  const Sweep sweep = test::blob_sweep(scene().patient, single);
  CollectingDiagnostics diagnostics;
  const auto result =
      register_sweep(scene().ct, sweep, test::true_pose(), test::small_options(60), diagnostics);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_TRUE(std::isinf(result->split_disagreement_mm));
  EXPECT_NE(result->split_fault.find("found one position"), std::string::npos)
      << result->split_fault;
  EXPECT_FALSE(decide(*result, {}, {{0, 0, 0}}).accepted);
}

TEST(ImageRegistrationTest, TheCallerCanCancelAtAnyTime) {
  CollectingDiagnostics diagnostics;
  for (const int calls : {1, 3, 10}) {
    int seen = 0;
    const auto result =
        register_sweep(scene().ct, scene().sweep, test::true_pose(), test::small_options(60),
                       diagnostics, [&](double) { return ++seen < calls; });
    EXPECT_TRUE(test::rejects(result, ErrorCode::kCancelled, {"cancelled"}));
    EXPECT_EQ(seen, calls);
  }
}

TEST(ImageRegistrationTest, ProgressGrowsToOne) {
  CollectingDiagnostics diagnostics;
  double last = 0;
  const auto result = register_sweep(scene().ct, scene().sweep, test::true_pose(),
                                     test::small_options(60), diagnostics, [&](double fraction) {
                                       EXPECT_GE(fraction, last);
                                       last = fraction;
                                       return true;
                                     });
  ASSERT_TRUE(test::has_value(result));
  EXPECT_EQ(last, 1.0);
}

TEST(ImageRegistrationTest, PatchesThatDoNotFitBecomeSmaller) {
  auto options = test::small_options(60);
  options.levels.insert(options.levels.begin(), LevelOptions{10.0, 21, 100, 9.0});
  CollectingDiagnostics diagnostics;
  const auto result = register_sweep(
      scene().ct, scene().sweep, test::off_by(test::true_pose(), 5, 0.05, 1), options, diagnostics);
  ASSERT_TRUE(test::has_value(result));
  ASSERT_EQ(result->levels.size(), 4u);
  EXPECT_GE(result->levels[0].patches, 20);
  EXPECT_TRUE(diagnostics.entries().empty());
}

TEST(ImageRegistrationTest, ALevelThatDoesNotFitIsLeftOutAndReported) {
  auto options = test::small_options(60);
  options.levels.insert(options.levels.begin(), LevelOptions{20.0, 21, 100, 9.0});
  CollectingDiagnostics diagnostics;
  const auto result = register_sweep(
      scene().ct, scene().sweep, test::off_by(test::true_pose(), 5, 0.05, 1), options, diagnostics);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_EQ(result->levels.size(), 3u);
  ASSERT_EQ(diagnostics.entries().size(), 1u);
  EXPECT_NE(diagnostics.entries()[0].message.find("level 0"), std::string::npos);
}

TEST(ImageRegistrationTest, RejectsInvalidOptionsByName) {
  const auto refused = [](auto change, const std::string& name) {
    ImageRegistrationOptions options;
    change(options);
    return test::rejects(validate(options), ErrorCode::kUsage, {name});
  };
  EXPECT_TRUE(test::has_value(validate(ImageRegistrationOptions{})));
  EXPECT_TRUE(refused([](auto& o) { o.levels.clear(); }, "levels"));
  EXPECT_TRUE(refused([](auto& o) { o.levels[1].patch_side = 8; }, "levels[1].patch_side"));
  EXPECT_TRUE(refused([](auto& o) { o.levels[0].sample_step_mm = 0.1; }, "coarse to fine"));
  EXPECT_TRUE(refused([](auto& o) { o.levels[0].patches = 3; }, "levels[0].patches"));
  EXPECT_TRUE(refused([](auto& o) { o.ridge = 0; }, "ridge"));
  EXPECT_TRUE(refused([](auto& o) { o.loss.scale = 0; }, "loss.scale"));
  EXPECT_TRUE(refused([](auto& o) { o.loss.scale = std::nan(""); }, "loss.scale"));
  EXPECT_TRUE(refused([](auto& o) { o.ridge = std::nan(""); }, "ridge"));
  EXPECT_TRUE(refused([](auto& o) { o.threads = 0; }, "threads"));
  EXPECT_TRUE(refused([](auto& o) { o.start_range_rad = 4; }, "start_range_rad"));
  EXPECT_TRUE(refused([](auto& o) { o.mask.drop_grey = 300; }, "drop_grey"));
}

}  // namespace
}  // namespace nav::registration
