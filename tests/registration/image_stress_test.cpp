// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <functional>
#include <gtest/gtest.h>

#include "registration/acceptance.hpp"
#include "registration/image_registration.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"

/// Difficult input must give either a correct result or a rejection with a reason.
namespace nav::registration {
namespace {

using test::BlobPatient;
using Pose = Transform<frames::Ct, frames::Reference>;

/// Outcome of a registration.
struct Outcome {
  bool accepted;
  double error_mm;      ///< Error of the pose, whether it was accepted or not.
  std::string reasons;  ///< Reasons for the rejection.
};

Outcome judge(const Volume& ct, const Sweep& sweep, const Pose& start,
              const Pose& truth = test::true_pose()) {
  CollectingDiagnostics diagnostics;
  const auto result = register_sweep(ct, sweep, start, test::small_options(60), diagnostics);
  if (!result) {
    EXPECT_EQ(result.error().code, ErrorCode::kRefused) << result.error().message;
    return {false, INFINITY, result.error().message};
  }
  const Decision decision = decide(*result, {}, {{0, 0, 0}});
  Outcome out{decision.accepted, test::cube_error_mm(result->ct_from_reference, truth), ""};
  for (const auto& reason : decision.reasons) out.reasons += reason + "; ";
  return out;
}

/// Rule of this file: an accepted pose is correct, and a rejection has a reason.
void expect_right_or_refused(const Outcome& outcome, double right_mm) {
  if (outcome.accepted) {
    EXPECT_LT(outcome.error_mm, right_mm);
  } else {
    EXPECT_FALSE(outcome.reasons.empty());
  }
}

Pose near() { return test::off_by(test::true_pose(), 5, 0.05, 1); }

/// Sweep with a change applied to each image.
Sweep altered(const std::function<void(TrackedImage&)>& change) {
  std::vector<TrackedImage> frames = test::blob_scene().sweep.frames();
  for (TrackedImage& tracked : frames) change(tracked);
  return *Sweep::create(std::move(frames), "altered");
}

Sweep with_greys(const std::function<double(int column, int row, double grey)>& grey) {
  return altered([&](TrackedImage& tracked) {
    const auto& old = tracked.frame.pixels;
    std::vector<std::uint8_t> pixels;
    for (int row = 0; row < old.height(); ++row) {
      for (int column = 0; column < old.width(); ++column) {
        const double x = grey(column, row, old.at(column, row));
        pixels.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(x, 0.0, 255.0))));
      }
    }
    tracked.frame.pixels = Image2d<std::uint8_t>(old.width(), old.height(), std::move(pixels));
  });
}

TEST(ImageStressTest, NamesADirectionThatTheSweepDoesNotDetermine) {
  const test::PrismaticPatient prism(test::blob_scene().patient);
  const Volume ct = test::blob_ct(prism, test::cubic_grid());
  CollectingDiagnostics diagnostics;
  // The start is the truth, shifted along the prism. Nothing determines this shift, and no result
  // may claim to.
  const auto truth = test::true_pose();
  const Pose start(truth.rotation(), truth.translation_mm() + Eigen::Vector3d(1, -1, 7));
  auto options = test::small_options(60);
  options.starts = 0;
  const auto result = register_sweep(ct, test::blob_sweep(prism, {}), start, options, diagnostics);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_FALSE(result->covariance_valid);
  EXPECT_NE(result->covariance_fault.find("translation along Ct"), std::string::npos)
      << result->covariance_fault;
  EXPECT_NE(result->covariance_fault.find("1.00)"), std::string::npos) << result->covariance_fault;
  const Decision decision = decide(*result, {}, {{0, 0, 0}});
  EXPECT_FALSE(decision.accepted);
  const auto p = truth.inverse() * Point<frames::Ct>{{0, 0, 0}};
  EXPECT_LT((result->ct_from_reference * p).mm.head<2>().norm(), 0.5);
}

TEST(ImageStressTest, ASweepInShadowIsRejected) {
  const Sweep sweep =
      with_greys([](int, int row, double grey) { return row < 12 ? 200 : std::min(grey, 0.0); });
  const Outcome outcome = judge(test::blob_scene().ct, sweep, near());
  EXPECT_FALSE(outcome.accepted);
  EXPECT_NE(outcome.reasons.find("patches"), std::string::npos) << outcome.reasons;
}

TEST(ImageStressTest, SaturatedImagesAreRejected) {
  const Sweep sweep = with_greys([](int, int, double) { return 255; });
  EXPECT_FALSE(judge(test::blob_scene().ct, sweep, near()).accepted);
}

TEST(ImageStressTest, SaturatedEchoesGiveACorrectPose) {
  const Sweep sweep = with_greys([](int, int, double grey) { return 3 * grey - 100; });
  const Outcome outcome = judge(test::blob_scene().ct, sweep, near());
  expect_right_or_refused(outcome, 1.0);
  EXPECT_LT(outcome.error_mm, 1.0);
}

TEST(ImageStressTest, AWrongPixelSizeIsCorrectOrRejected) {
  for (const double scale : {0.8, 1.25}) {
    const Sweep sweep = altered([&](TrackedImage& t) { t.frame.grid.mm_per_pixel *= scale; });
    expect_right_or_refused(judge(test::blob_scene().ct, sweep, near()), 2.0);
  }
}

TEST(ImageStressTest, AWrongSpeedOfSoundIsCorrectOrRejected) {
  for (const double scale : {0.94, 1.03}) {
    const Sweep sweep =
        altered([&](TrackedImage& t) { t.frame.grid.mm_per_pixel.col(1) *= scale; });
    expect_right_or_refused(judge(test::blob_scene().ct, sweep, near()), 3.0);
  }
}

TEST(ImageStressTest, UpsideDownStartsAreCorrectOrRejected) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::Unit(axis)));
    const auto truth = test::true_pose();
    const Pose start((turn * truth.rotation()).normalized(), turn * truth.translation_mm());
    expect_right_or_refused(judge(test::blob_scene().ct, test::blob_scene().sweep, start), 1.0);
  }
}

TEST(ImageStressTest, ThickSlicesGiveACorrectPose) {
  VoxelGrid grid = test::cubic_grid(60, 2.0);
  grid.size = {301, 301, 25};
  grid.spacing_mm = {0.4, 0.4, 5.0};
  const Volume ct = test::blob_ct(test::blob_scene().patient, grid);
  test::SweepSpec spec;
  spec.frames = 20;
  spec.size_px = 96;
  const Outcome outcome = judge(ct, test::blob_sweep(test::blob_scene().patient, spec), near());
  expect_right_or_refused(outcome, 1.0);
  EXPECT_LT(outcome.error_mm, 1.0);
}

TEST(ImageStressTest, ALeftHandedGridIsNotMirrored) {
  // This CT has the same patient, but its voxels start at the other end of x. Only the positions
  // matter.
  VoxelGrid grid = test::cubic_grid();
  grid.directions.col(0) *= -1;
  grid.origin_mm.x() *= -1;
  const Outcome outcome =
      judge(test::blob_ct(test::blob_scene().patient, grid), test::blob_scene().sweep, near());
  EXPECT_TRUE(outcome.accepted) << outcome.reasons;
  EXPECT_LT(outcome.error_mm, 0.5);
}

TEST(ImageStressTest, TinyOverlapIsRejected) {
  VoxelGrid grid = test::cubic_grid(25);
  grid.origin_mm += Eigen::Vector3d(50, 40, 30);
  const Outcome outcome =
      judge(test::blob_ct(test::blob_scene().patient, grid), test::blob_scene().sweep, near());
  EXPECT_FALSE(outcome.accepted);
  EXPECT_NE(outcome.reasons.find("CT"), std::string::npos) << outcome.reasons;
}

TEST(ImageStressTest, ShuffledPosesAreRejected) {
  // Each image gets the pose of another image, so tracking and images do not belong together.
  std::vector<TrackedImage> frames = test::blob_scene().sweep.frames();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].reference_from_image =
        test::blob_scene().sweep.frames()[(i * 7 + 5) % frames.size()].reference_from_image;
  }
  const auto sweep = Sweep::create(std::move(frames), "shuffled");
  ASSERT_TRUE(test::has_value(sweep));
  EXPECT_FALSE(judge(test::blob_scene().ct, *sweep, near()).accepted);
}

}  // namespace
}  // namespace nav::registration
