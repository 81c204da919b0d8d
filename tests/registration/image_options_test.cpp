// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "registration/acceptance.hpp"
#include "registration/image_strain.hpp"
#include "registration/motion/volume_sweep.hpp"
#include "registration/prepared.hpp"
#include "registration/similarity/mutual_information.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"

/// Tests the similarities besides LC², the scale models, and volumes as moving images.
namespace nav::registration {
namespace {

using test::BlobPatient;

struct PatientScene {
  BlobPatient patient{11};
  Volume ct = test::blob_ct(patient, test::cubic_grid());
  Sweep sweep = test::blob_sweep(patient, {.echo = 0});
};
const PatientScene& scene() {
  static const PatientScene instance;
  return instance;
}

Result<ImageRegistrationResult> solve(const Sweep& sweep, const ImageRegistrationOptions& options,
                                      unsigned seed = 1) {
  CollectingDiagnostics diagnostics;
  return register_sweep(scene().ct, sweep, test::off_by(test::true_pose(), 5, 0.05, seed), options,
                        diagnostics);
}

double error_mm(const ImageRegistrationResult& result) {
  return test::cube_error_mm(result.ct_from_reference, test::true_pose());
}

TEST(SimilarityTest, EachSimilarityFindsTheTruePose) {
  for (const Similarity similarity :
       {Similarity::kLc2, Similarity::kNcc, Similarity::kMutualInformation}) {
    auto options = test::small_options();
    options.similarity = similarity;
    for (unsigned seed = 1; seed <= 2; ++seed) {
      const auto result = solve(scene().sweep, options, seed);
      ASSERT_TRUE(test::has_value(result));
      EXPECT_LT(error_mm(*result), 0.5) << to_string(similarity) << ' ' << seed;
      EXPECT_LT(result->final_cost, result->initial_cost);
      EXPECT_TRUE(result->covariance_valid) << result->covariance_fault;
    }
  }
}

TEST(PatchChoiceTest, EvenPatchesFindTheTruePoseAndFlatOnesAreLeftOut) {
  auto options = test::small_options();
  options.levels.back().choice = PatchChoice::kEven;
  const auto result = solve(scene().sweep, options);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_LT(error_mm(*result), 0.5);
  EXPECT_LE(result->used_patches, result->patches);
  // With a limit of 0 no patch is left out.
  options.min_ct_contrast_hu = 0;
  const auto all = solve(scene().sweep, options);
  ASSERT_TRUE(test::has_value(all));
  EXPECT_EQ(all->used_patches, all->patches);
  EXPECT_LE(result->used_patches, all->used_patches);
  options.min_ct_contrast_hu = -1;
  EXPECT_EQ(solve(scene().sweep, options).error().code, ErrorCode::kUsage);
}

/// Prepared CT and sweep, to evaluate the cost of one level directly.
struct PreparedScene {
  PreparedCt ct = *PreparedCt::create(scene().ct, test::small_options());
  PreparedSweep sweep = prepared_sweep();
  static PreparedSweep prepared_sweep() {
    CollectingDiagnostics diagnostics;
    return *PreparedSweep::create(scene().sweep, test::small_options(), diagnostics);
  }
};

TEST(LossTest, ALossReducesTheEffectOfImagesWithAWrongPose) {
  // Every fourth image is displaced by 6 mm.
  std::vector<TrackedImage> frames = scene().sweep.frames();
  for (std::size_t i = 0; i < frames.size(); i += 4) {
    const auto& pose = frames[i].reference_from_image;
    frames[i].reference_from_image = Transform<frames::Reference, frames::Image>(
        pose.rotation(), pose.translation_mm() + Eigen::Vector3d(0, 6, 0));
  }
  const auto torn = Sweep::create(std::move(frames), "torn");
  ASSERT_TRUE(test::has_value(torn));
  const auto error_with = [&](const RobustLoss& loss) {
    auto options = test::small_options();
    options.loss = loss;
    options.delay_sigma_s = 0;  // A probe that jumps has no speed.
    const auto result = solve(*torn, options);
    EXPECT_TRUE(test::has_value(result));
    return result ? error_mm(*result) : 1e9;
  };
  const double plain = error_with({PatchLoss::kNone, 1});
  EXPECT_LT(error_with({PatchLoss::kCauchy, 0.1}), 0.7 * plain);
  EXPECT_LT(error_with({PatchLoss::kGemanMcClure, 0.2}), 0.7 * plain);
  // With a delay from such speeds, nothing wrong is accepted.
  const auto delayed = solve(*torn, test::small_options());
  ASSERT_TRUE(test::has_value(delayed));
  EXPECT_TRUE(error_mm(*delayed) < 2 || !decide(*delayed, {}, {{0, 0, 0}}).accepted);
}

TEST(SimilarityTest, GradientsAreTheDerivativesOfTheCost) {
  const PreparedScene prepared;
  const auto pose = test::off_by(test::true_pose(), 2, 0.02, 3);
  const Eigen::Vector3d centre(5, -3, 8);
  for (const Similarity similarity : {Similarity::kNcc, Similarity::kMutualInformation}) {
    const SimilarityCost cost(*prepared.ct.levels()[1], prepared.sweep.levels()[1].patches, 0.005,
                              1, measure_of(similarity));
    const CostTerms terms = cost.terms(pose, centre, true);
    EXPECT_NEAR(terms.cost, cost.cost(pose).cost, 1e-9);
    Vector6d sum = Vector6d::Zero();
    for (const Vector6d& g : terms.patch_gradients) sum += g;
    EXPECT_LT((sum - terms.gradient).norm(), 1e-6 * terms.gradient.norm());
    for (Eigen::Index axis = 0; axis < 6; ++axis) {
      // The kinks of the trilinear interpolation average out over 20 000 samples.
      const double h = axis < 3 ? 1e-4 : 5e-3;
      const double up = cost.cost(moved(pose, centre, h * Vector6d::Unit(axis))).cost;
      const double down = cost.cost(moved(pose, centre, -h * Vector6d::Unit(axis))).cost;
      const double slope = 0.5 * (up - down) / (2 * h);
      EXPECT_NEAR(slope, terms.gradient[axis],
                  0.02 * terms.gradient.segment(axis / 3 * 3, 3).norm())
          << to_string(similarity) << ' ' << axis;
    }
  }
}

TEST(SimilarityTest, MutualInformationIgnoresAMonotoneChangeOfGreys) {
  // A gamma of 0.5 keeps the order of the bins. The mutual information hardly changes, while an
  // affine model loses some of the match.
  std::vector<TrackedImage> frames = scene().sweep.frames();
  for (TrackedImage& tracked : frames) {
    std::vector<std::uint8_t> pixels(tracked.frame.pixels.pixels().begin(),
                                     tracked.frame.pixels.pixels().end());
    for (auto& p : pixels)
      p = static_cast<std::uint8_t>(255 - std::lround(255 * std::pow(p / 255.0, 0.5)));
    tracked.frame.pixels = Image2d<std::uint8_t>(tracked.frame.pixels.width(),
                                                 tracked.frame.pixels.height(), std::move(pixels));
  }
  const auto dark = Sweep::create(std::move(frames), "inverted");
  ASSERT_TRUE(test::has_value(dark));
  auto options = test::small_options();
  options.similarity = Similarity::kMutualInformation;
  options.mask.drop_grey = 254;  // An inverted image does not end in a shadow.
  const auto result = solve(*dark, options);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_LT(error_mm(*result), 0.5);
}

TEST(SimilarityTest, FlatImagesHaveNoInformation) {
  const PreparedScene prepared;
  PatchSet flat = prepared.sweep.levels()[0].patches;
  for (Patch& patch : flat.patches) patch.norm_grey = patch.mean_grey = 0;
  const CostTerms terms = SimilarityCost(*prepared.ct.levels()[0], flat, 0.005, 1,
                                         measure_of(Similarity::kMutualInformation))
                              .terms(test::true_pose(), {0, 0, 0});
  EXPECT_EQ(terms.cost, 1.0);
  EXPECT_EQ(terms.gradient.norm(), 0);
}

/// Sweep of a scanner that assumes another speed of sound: depths are divided by \p scale.
Sweep misread(double scale) {
  std::vector<TrackedImage> frames = scene().sweep.frames();
  for (TrackedImage& tracked : frames) tracked.frame.grid.mm_per_pixel.col(1) /= scale;
  return *Sweep::create(std::move(frames), "misread");
}

TEST(ImageScaleTest, FindsTheSpeedOfSound) {
  auto options = test::small_options();
  for (const double scale : {0.96, 1.03}) {
    const Sweep sweep = misread(scale);
    options.stretch = ScaleModel::kNone;
    const auto rigid = solve(sweep, options);
    options.stretch = ScaleModel::kSoundSpeed;
    const auto found = solve(sweep, options);
    ASSERT_TRUE(test::has_value(rigid));
    ASSERT_TRUE(test::has_value(found));
    EXPECT_NEAR(found->stretch.depth_scale, scale, 0.004);
    EXPECT_LT(error_mm(*found), 0.6);
    EXPECT_LT(error_mm(*found), 0.7 * error_mm(*rigid));
    EXPECT_LT(found->final_cost, rigid->final_cost);
    // The predicted error holds with the scale as without.
    EXPECT_LT(error_mm(*found), 2 * found->tre_rms_mm({{0, 0, 0}}));
    EXPECT_LT(error_mm(*rigid), 2 * rigid->tre_rms_mm({{0, 0, 0}}));
    EXPECT_EQ(rigid->stretch.depth_scale, 1.0);
    // A result with a scale is rejected in any case, because the displayed image is not scaled.
    const Decision decision = decide(*found, {}, {{0, 0, 0}});
    ASSERT_FALSE(decision.accepted);
    EXPECT_NE(decision.reasons.back().find("scale of the images"), std::string::npos);
  }
}

TEST(ImageScaleTest, FindsAnAffineStrainAndNoneIfThereIsNone) {
  auto options = test::small_options();
  options.stretch = ScaleModel::kAffine;
  const auto plain = solve(scene().sweep, options);
  ASSERT_TRUE(test::has_value(plain));
  EXPECT_LT(plain->stretch.strain.norm(), 0.01);
  EXPECT_LT(error_mm(*plain), 0.6);
  const auto found = solve(misread(1.03), options);
  ASSERT_TRUE(test::has_value(found));
  // The beams are nearly parallel, so the strain acts along the depth.
  const Eigen::Vector3d beam =
      scene().sweep.frames()[12].reference_from_image.rotation() * Eigen::Vector3d::UnitY();
  EXPECT_NEAR(beam.dot(found->stretch.strain * beam), 0.03, 0.008);
}

TEST(ImageScaleTest, KeepsTheTimeLimit) {
  auto options = test::small_options();
  options.stretch = ScaleModel::kAffine;
  options.delay_sigma_s = options.scale_sigma = options.calibration_sigma_mm = 0;
  options.pressed_sigma_mm = 0;
  CollectingDiagnostics diagnostics;
  int asked = 0;
  const auto result =
      register_sweep(scene().ct, misread(1.03), test::off_by(test::true_pose(), 5, 0.05, 1),
                     options, diagnostics, [&](double fraction) {
                       // The callback is called when all levels are solved before the scale model,
                       // and at each of its steps.
                       if (fraction > 0.8 && ++asked == 3) options.time_limit_s = 1e-9;
                       return true;
                     });
  ASSERT_TRUE(test::has_value(result));
  EXPECT_EQ(result->termination, Termination::kTimeLimit) << result->message;
  EXPECT_GT(result->stretch.strain.norm(), 0) << "the step before is kept";
}

TEST(ImageScaleTest, RejectsMutualInformation) {
  auto options = test::small_options();
  options.stretch = ScaleModel::kAffine;
  options.similarity = Similarity::kMutualInformation;
  EXPECT_TRUE(
      test::rejects(solve(scene().sweep, options), ErrorCode::kUsage, {"scale", "patches"}));
}

/// Ultrasound volume of the patient with the axes (slice, lateral, depth) and voxels of 2 x 1.5 x
/// 1.5 mm.
UltrasoundVolume blob_volume() {
  UltrasoundVolume volume;
  volume.grid.size = {40, 60, 64};
  volume.grid.spacing_mm = {2.0, 1.5, 1.5};
  volume.lateral_axis = 1;
  volume.depth_axis = 2;
  volume.name = "matrix probe";
  const auto reference_from_ct = test::true_pose().inverse();
  volume.grid.directions = reference_from_ct.rotation().toRotationMatrix();
  volume.grid.origin_mm = (reference_from_ct * Point<frames::Ct>{{-40, -45, -48}}).mm;
  for (int k = 0; k < 64; ++k) {
    for (int j = 0; j < 60; ++j) {
      for (int i = 0; i < 40; ++i) {
        const Eigen::Vector3d p =
            (test::true_pose() *
             Point<frames::Reference>{volume.grid.at({1.0 * i, 1.0 * j, 1.0 * k}).mm})
                .mm;
        const double grey = 60 + 0.7 * scene().patient.hu(p);
        volume.grey.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0, 255.0))));
      }
    }
  }
  return volume;
}

TEST(VolumeSweepTest, AVolumeRegistersLikeItsSlices) {
  const UltrasoundVolume volume = blob_volume();
  const auto sweep = sweep_of_volume(volume);
  ASSERT_TRUE(test::has_value(sweep));
  ASSERT_EQ(sweep->frames().size(), 40u);
  // The position of a voxel is the position of its pixel.
  const TrackedImage& tracked = sweep->frames()[7];
  EXPECT_EQ(tracked.frame.pixels.at(20, 30), volume.grey[(30 * 60 + 20) * 40 + 7]);
  EXPECT_LT(((tracked.reference_from_image * tracked.frame.grid.at(20, 30)).mm -
             volume.grid.at({7, 20, 30}).mm)
                .norm(),
            1e-9);
  const auto result = solve(*sweep, test::small_options());
  ASSERT_TRUE(test::has_value(result));
  EXPECT_LT(error_mm(*result), 0.6);
}

TEST(VolumeSweepTest, RejectsInvalidVolumes) {
  const auto code = ErrorCode::kMalformedData;
  UltrasoundVolume volume = blob_volume();
  volume.grey.pop_back();
  EXPECT_TRUE(test::rejects(sweep_of_volume(volume), code, {"matrix probe", "voxels"}));
  volume = blob_volume();
  volume.depth_axis = 1;
  EXPECT_TRUE(test::rejects(sweep_of_volume(volume), code, {"axes", "1 and 1"}));
  volume.grid.size = {1, 60, 40 * 64};
  volume.depth_axis = 2;
  EXPECT_TRUE(test::rejects(sweep_of_volume(volume), code, {"2 slices"}));
}

}  // namespace
}  // namespace nav::registration
