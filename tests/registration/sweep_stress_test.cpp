// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cfenv>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <random>

#include "registration/acceptance.hpp"
#include "registration/image_registration.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"

/// Sweeps that are short, or have a wrong gain, wrong times or unusual poses must give either a
/// correct result or a rejection with a reason.
namespace nav::registration {
namespace {

using SweepPose = Transform<frames::Reference, frames::Image>;
using CtPose = Transform<frames::Ct, frames::Reference>;

struct StressOutcome {
  bool accepted;
  double error_mm;
  std::string reasons;
  double predicted_mm = INFINITY;
};

StressOutcome run(const Volume& ct, const Sweep& sweep,
                  const ImageRegistrationOptions& options = test::small_options(60)) {
  CollectingDiagnostics diagnostics;
  const auto start = test::off_by(test::true_pose(), 5, 0.05, 1);
  const auto result = register_sweep(ct, sweep, start, options, diagnostics);
  if (!result) {
    EXPECT_EQ(result.error().code, ErrorCode::kRefused) << result.error().message;
    return {false, INFINITY, result.error().message};
  }
  const Decision decision = decide(*result, {}, {{0, 0, 0}});
  StressOutcome out{decision.accepted,
                    test::cube_error_mm(result->ct_from_reference, test::true_pose()), "",
                    result->tre_rms_mm({{0, 0, 0}})};
  for (const auto& reason : decision.reasons) out.reasons += reason + "; ";
  return out;
}

Sweep with_frames(const std::function<void(std::size_t, TrackedImage&)>& change) {
  std::vector<TrackedImage> frames = test::blob_scene().sweep.frames();
  for (std::size_t i = 0; i < frames.size(); ++i) change(i, frames[i]);
  return *Sweep::create(std::move(frames), "altered");
}

Sweep with_pixels(const std::function<double(int column, int row, double grey)>& grey) {
  return with_frames([&](std::size_t, TrackedImage& tracked) {
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

/// Sweep of a tracker that reports the pose of another time for each image.
Sweep late_by(double images) {
  const auto& frames = test::blob_scene().sweep.frames();
  return with_frames([&](std::size_t i, TrackedImage& tracked) {
    const double at =
        std::clamp(static_cast<double>(i) + images, 0.0, static_cast<double>(frames.size() - 1));
    const auto before = static_cast<std::size_t>(at);
    const std::size_t after = std::min(before + 1, frames.size() - 1);
    tracked.reference_from_image =
        interpolate(frames[before].reference_from_image, frames[after].reference_from_image,
                    at - static_cast<double>(before));
  });
}

void expect_right_or_refused(const StressOutcome& outcome, double right_mm) {
  if (outcome.accepted) {
    EXPECT_LT(outcome.error_mm, right_mm);
  } else {
    EXPECT_FALSE(outcome.reasons.empty());
  }
}

TEST(SweepStressTest, OneToTenImagesAreCorrectOrRejected) {
  for (const std::size_t count : {1, 2, 3, 5, 10}) {
    // The images are spread evenly over the sweep.
    std::vector<TrackedImage> frames;
    const auto& all = test::blob_scene().sweep.frames();
    for (std::size_t i = 0; i < count; ++i)
      frames.push_back(all[(2 * i + 1) * all.size() / (2 * count)]);
    const auto sweep = Sweep::create(std::move(frames), "few");
    ASSERT_TRUE(test::has_value(sweep));
    const StressOutcome outcome = run(test::blob_scene().ct, *sweep);
    expect_right_or_refused(outcome, 1.5);
    if (count == 1) {
      EXPECT_FALSE(outcome.accepted);
    }
    if (count == 10) {
      EXPECT_LT(outcome.error_mm, 1.0);
    }
  }
}

TEST(SweepStressTest, GainGammaNoiseAndDepthGainAreCorrectOrRejected) {
  std::mt19937 random(3);
  const std::vector<std::pair<const char*, Sweep>> sweeps{
      {"gain x 1.4, saturating", with_pixels([](int, int, double g) { return 1.4 * g; })},
      {"gamma 0.6", with_pixels([](int, int, double g) { return 255 * std::pow(g / 255, 0.6); })},
      {"noise of 40 grey levels", with_pixels([&](int, int, double g) {
         return g + 40 * (2 * (static_cast<double>(random()) / 4294967296.0) - 1);
       })},
      {"gain that grows with depth",
       with_pixels([](int, int row, double g) { return g * (0.6 + 0.008 * row); })}};
  for (const auto& [name, sweep] : sweeps) {
    SCOPED_TRACE(name);
    const StressOutcome outcome = run(test::blob_scene().ct, sweep);
    expect_right_or_refused(outcome, 1.0);
  }
}

TEST(SweepStressTest, SomeBlackAndWhiteImagesDoNoHarm) {
  const Sweep sweep = with_frames([](std::size_t i, TrackedImage& tracked) {
    if (i % 5 != 2) return;
    const auto& old = tracked.frame.pixels;
    const std::uint8_t grey = i % 2 == 0 ? 0 : 255;
    tracked.frame.pixels = Image2d<std::uint8_t>(
        old.width(), old.height(), std::vector<std::uint8_t>(old.pixels().size(), grey));
  });
  const StressOutcome outcome = run(test::blob_scene().ct, sweep);
  EXPECT_LT(outcome.error_mm, 0.8) << outcome.reasons;
}

TEST(SweepStressTest, ADelayOfTwoImagesIsCorrectOrRejected) {
  // 24 images, 4 mm apart. At 20 images per second, 100 ms are two images, 8 mm. The hand tilts a
  // little on its way. Only this distinguishes a delay from a shift.
  for (const double images : {-2.0, 2.0}) {
    const StressOutcome outcome = run(test::blob_scene().ct, late_by(images));
    EXPECT_LT(outcome.error_mm, 8.0 + 1.5);
    expect_right_or_refused(outcome, 2.0);
  }
}

TEST(SweepStressTest, AScaleErrorOfThreePercentIsCorrectOrRejected) {
  for (const double scale : {0.97, 1.03}) {
    const Sweep sweep = with_frames([&](std::size_t, TrackedImage& tracked) {
      tracked.frame.grid.mm_per_pixel *= scale;
      tracked.frame.grid.origin_mm *= scale;
    });
    const StressOutcome outcome = run(test::blob_scene().ct, sweep);
    expect_right_or_refused(outcome, 2.0);
  }
}

TEST(SweepStressTest, TheOrderOfImagesHardlyMatters) {
  std::vector<TrackedImage> frames = test::blob_scene().sweep.frames();
  std::vector<Timestamp> times;
  for (const auto& tracked : frames) times.push_back(tracked.frame.acquired);
  std::reverse(frames.begin(), frames.end());
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].frame.acquired = times[i];
  const auto reversed = Sweep::create(std::move(frames), "reversed");
  ASSERT_TRUE(test::has_value(reversed));
  const StressOutcome forth = run(test::blob_scene().ct, test::blob_scene().sweep);
  const StressOutcome back = run(test::blob_scene().ct, *reversed);
  EXPECT_TRUE(back.accepted) << back.reasons;
  // Other images are left out, so other patches are chosen.
  EXPECT_NEAR(back.error_mm, forth.error_mm, 0.3);
}

TEST(SweepStressTest, GimbalLockAndNegativeQuaternionsDoNotMatter) {
  // A sweep with the same images in a Reference that is rotated so that the Euler angles of the
  // pose are singular.
  for (const double pitch : {M_PI_2, -M_PI_2, M_PI}) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()));
    const Eigen::Quaterniond opposite(-turn.w(), -turn.x(), -turn.y(), -turn.z());
    const Transform<frames::Reference, frames::Reference> turned(turn, Eigen::Vector3d(3, 4, 5));
    const Transform<frames::Reference, frames::Reference> negated(opposite,
                                                                  Eigen::Vector3d(3, 4, 5));
    CollectingDiagnostics diagnostics;
    std::vector<CtPose> found;
    for (const auto& to : {turned, negated}) {
      const Sweep sweep = with_frames([&](std::size_t, TrackedImage& tracked) {
        tracked.reference_from_image = to * tracked.reference_from_image;
      });
      const auto start = test::off_by(test::true_pose(), 5, 0.05, 1) * to.inverse();
      const auto result =
          register_sweep(test::blob_scene().ct, sweep, start, test::small_options(60), diagnostics);
      ASSERT_TRUE(test::has_value(result));
      found.push_back(result->ct_from_reference * to);
      EXPECT_LT(test::cube_error_mm(found.back(), test::true_pose()), 0.5) << pitch;
    }
    EXPECT_LT(test::cube_error_mm(found[0], found[1]), 1e-6);
  }
}

TEST(SweepStressTest, DistantStartsAreRejectedAndDoNotCrash) {
  for (const double far_mm : {2e3, 1e6, 1e12}) {
    CollectingDiagnostics diagnostics;
    const CtPose away(test::true_pose().rotation(),
                      test::true_pose().translation_mm() + Eigen::Vector3d(0, far_mm, 0));
    EXPECT_TRUE(test::rejects(register_sweep(test::blob_scene().ct, test::blob_scene().sweep, away,
                                             test::small_options(60), diagnostics),
                              ErrorCode::kRefused, {"outside"}));
  }
}

/// Detects every invalid floating-point operation between construction and the check, without a
/// signal.
class InvalidOperations {
 public:
  InvalidOperations() { std::feclearexcept(FE_INVALID); }
  [[nodiscard]] bool seen() const { return std::fetestexcept(FE_INVALID) != 0; }
};

TEST(SweepStressTest, GoodInputCausesNoInvalidOperation) {
  const InvalidOperations operations;
  CollectingDiagnostics diagnostics;
  auto options = test::small_options(60);
  for (const int starts : {0, 60}) {
    options.starts = starts;
    const auto result =
        register_sweep(test::blob_scene().ct, test::blob_scene().sweep,
                       test::off_by(test::true_pose(), 5, 0.05, 1), options, diagnostics);
    ASSERT_TRUE(test::has_value(result));
  }
  EXPECT_FALSE(operations.seen());
}

TEST(SweepStressTest, ASignalOfTwoGreyLevelsIsCorrectOrRejected) {
  // Two grey levels remain after a gain that is almost off.
  const Sweep sweep = with_pixels([](int, int, double g) { return g > 100 ? 91 : 90; });
  expect_right_or_refused(run(test::blob_scene().ct, sweep), 1.5);
}

}  // namespace
}  // namespace nav::registration
