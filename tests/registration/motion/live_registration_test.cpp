// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/motion/live_registration.hpp"

#include <algorithm>
#include <gmock/gmock.h>

#include "tests/registration/synthetic.hpp"

namespace nav::registration {
namespace {

using frames::Ct;
using frames::Reference;
using ::testing::HasSubstr;
using Vec = Eigen::Vector3d;

constexpr int kFrames = 60;
constexpr double kPeriodS = 0.066;
// Solves stop at steps of 1e-3 mm or some iterations earlier, depending on rounding.
constexpr double kStopMm = 0.05;

struct Scene {
  test::BlobPatient patient{3, 150};
  std::shared_ptr<const CtChannels> ct;
  std::vector<TrackedImage> frames;
  LiveOptions options;

  Scene() {
    const VoxelGrid grid = test::cubic_grid(70);
    const Volume volume = test::blob_ct(patient, grid);
    const auto channels = make_ct_channels(volume, box_of(grid), 0.75 * 1.6);
    ct = std::make_shared<const CtChannels>(*channels);
    test::SweepSpec spec;
    spec.frames = kFrames;
    spec.step_mm = 1;
    spec.size_px = 80;
    const Sweep sweep = test::blob_sweep(patient, spec);
    frames = sweep.frames();
    for (std::size_t i = 0; i < frames.size(); ++i) {
      frames[i].frame.acquired = Timestamp(from_seconds(kPeriodS * static_cast<double>(i)));
      frames[i].frame.received = frames[i].frame.acquired;
    }
  }
};

const Scene& scene() {
  static const Scene instance;
  return instance;
}

/// True pose of an image after the tissue of the patient moved in Reference.
Pose true_pose(const Transform<Reference, Reference>& tissue) {
  return test::true_pose() * tissue.inverse();
}

TrackedImage carried(const TrackedImage& image, const Transform<Reference, Reference>& tissue) {
  TrackedImage moved_image = image;
  moved_image.reference_from_image = tissue * image.reference_from_image;
  return moved_image;
}

/// Displacement by a breath of 4 s and \p mm amplitude, mostly along one axis.
Transform<Reference, Reference> breath(double mm, std::size_t frame) {
  const double s = std::sin(M_PI * kPeriodS * static_cast<double>(frame) / 4);
  const double depth = s * s;
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.03 * depth, Vec(0, 1, 1).normalized())),
          depth * mm * Vec(0.3, 0.2, 0.93)};
}

double error_mm(const TrackedImage& image, const Pose& found, const Pose& truth) {
  double sum = 0;
  for (const double column : {0.0, 79.0}) {
    for (const double row : {0.0, 79.0}) {
      const auto p = image.reference_from_image * image.frame.grid.at(column, row);
      sum += ((found * p).mm - (truth * p).mm).squaredNorm() / 4;
    }
  }
  return std::sqrt(sum);
}

LiveRegistration start(const LiveOptions& options, const Pose& accepted = test::true_pose()) {
  auto live = LiveRegistration::create(scene().ct, accepted, options);
  EXPECT_TRUE(live.has_value()) << live.error().message;
  return std::move(*live);
}

TEST(LiveRegistrationTest, FollowsABreathingPatient) {
  auto live = start({});
  std::vector<double> errors;
  double without = 0;
  for (std::size_t i = 0; i < scene().frames.size(); ++i) {
    const auto tissue = breath(10, i);
    const auto image = carried(scene().frames[i], tissue);
    const auto update = live.update(image);
    ASSERT_TRUE(update) << update.error().message;
    EXPECT_EQ(update->state, LiveState::kFollowing) << update->cause;
    errors.push_back(error_mm(image, update->ct_from_reference, true_pose(tissue)));
    without = std::max(without, error_mm(image, test::true_pose(), true_pose(tissue)));
  }
  EXPECT_GT(without, 8) << "the patient does move";
  std::ranges::sort(errors);
  // The motion is mostly perpendicular to the images, which determine that direction least.
  EXPECT_LT(errors[errors.size() / 2], 1.8);
  EXPECT_LT(errors.back(), 4);
  RecordProperty("median_um", static_cast<int>(1000 * errors[errors.size() / 2]));
  RecordProperty("max_um", static_cast<int>(1000 * errors.back()));
}

TEST(LiveRegistrationTest, ManyImagesOfAnotherPatientWithdrawTheRegistration) {
  test::SweepSpec spec;
  spec.frames = kFrames;
  spec.step_mm = 1;
  spec.size_px = 80;
  const Sweep other = test::blob_sweep(test::BlobPatient(9, 150), spec);
  LiveOptions options;
  options.max_cost = 1;   // No single image is rejected.
  options.drift_mm = 90;  // The registration follows the pose wherever it leads.
  options.jump_mm = 100;
  options.evidence_images = 39;
  auto right = start(options);
  auto wrong = start(options);
  for (std::size_t i = 0; i < other.frames().size(); ++i) {
    TrackedImage image = other.frames()[i];
    image.frame.acquired = scene().frames[i].frame.acquired;
    const auto own = right.update(scene().frames[i]);
    const auto update = wrong.update(image);
    ASSERT_TRUE(own);
    ASSERT_TRUE(update);
    EXPECT_EQ(own->state, LiveState::kFollowing) << own->cause;
    EXPECT_EQ(update->state, i < 38 ? LiveState::kFollowing : LiveState::kLost) << i;
    EXPECT_THAT(update->cause, HasSubstr(i < 38 ? "" : "another patient"));
  }
  wrong.accept(test::true_pose());
  TrackedImage next = scene().frames.back();
  next.frame.acquired += std::chrono::seconds(1);
  EXPECT_EQ(wrong.update(next)->state, LiveState::kFollowing) << "a new registration counts anew";
}

TEST(LiveRegistrationTest, StaysFixedForAPatientWhoDoesNotMove) {
  auto live = start({});
  double worst = 0;
  for (const auto& image : scene().frames) {
    const auto update = live.update(image);
    ASSERT_TRUE(update);
    worst = std::max(worst, error_mm(image, update->ct_from_reference, test::true_pose()));
    EXPECT_EQ(update->state, LiveState::kFollowing);
    EXPECT_GT(update->predicted_rms_mm, 0);
  }
  EXPECT_LT(worst, 3.2);
}

TEST(LiveRegistrationTest, ReducesASmallErrorOfTheAcceptedPose) {
  auto live = start({}, test::off_by(test::true_pose(), 3, 0.03, 4));
  double last = 0;
  for (const auto& image : scene().frames) {
    const auto update = live.update(image);
    ASSERT_TRUE(update);
    last = error_mm(image, update->ct_from_reference, test::true_pose());
  }
  EXPECT_LT(last, 1.6);
}

TEST(LiveRegistrationTest, ReportsDriftIfThePatientWasMoved) {
  LiveOptions options;
  options.drift_s = 1;
  auto live = start(options);
  const Transform<Reference, Reference> pushed(Eigen::Quaterniond::Identity(), {0, 12, 0});
  bool alarmed = false;
  for (std::size_t i = 0; i < scene().frames.size(); ++i) {
    // The patient is pushed slowly, as by a surgeon who leans on the patient.
    const double share = std::min(1.0, static_cast<double>(i) / 25);
    const Transform<Reference, Reference> tissue(Eigen::Quaterniond::Identity(),
                                                 share * pushed.translation_mm());
    const auto update = live.update(carried(scene().frames[i], tissue));
    ASSERT_TRUE(update);
    if (i < 10) {
      EXPECT_EQ(update->state, LiveState::kFollowing) << update->cause;
    }
    alarmed = alarmed || update->state == LiveState::kDrifted;
    if (update->state == LiveState::kDrifted) {
      EXPECT_THAT(update->cause, HasSubstr("accepted"));
    }
  }
  EXPECT_TRUE(alarmed);
}

TEST(LiveRegistrationTest, BlackImagesHoldThePoseAndThenLoseIt) {
  auto live = start({});
  for (std::size_t i = 0; i < 10; ++i) ASSERT_TRUE(live.update(scene().frames[i]));
  std::vector<LiveState> states;
  for (std::size_t i = 10; i < 20; ++i) {
    TrackedImage black = scene().frames[i];
    black.frame.pixels = Image2d<std::uint8_t>(80, 80, std::vector<std::uint8_t>(6400, 0));
    const auto update = live.update(black);
    ASSERT_TRUE(update) << update.error().message;
    states.push_back(update->state);
  }
  EXPECT_EQ(states.front(), LiveState::kHolding);
  EXPECT_EQ(states.back(), LiveState::kLost);
  const auto back = live.update(scene().frames[20]);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->state, LiveState::kFollowing) << "found again where the filter still reaches";
  EXPECT_LT(error_mm(scene().frames[20], back->ct_from_reference, test::true_pose()), 3);
}

TEST(LiveRegistrationTest, ContinuesIfTheDepthOfTheImagesChanges) {
  auto live = start({});
  for (std::size_t i = 0; i < 10; ++i) ASSERT_TRUE(live.update(scene().frames[i]));
  // The number of pixels stays equal, but their size changes: the middle of the image is enlarged.
  constexpr double kSize = 0.8;
  constexpr double kFirst = 8;
  for (std::size_t i = 10; i < 20; ++i) {
    TrackedImage zoomed = scene().frames[i];
    const auto& pixels = scene().frames[i].frame.pixels;
    std::vector<std::uint8_t> larger;
    for (int row = 0; row < 80; ++row) {
      for (int column = 0; column < 80; ++column) {
        larger.push_back(pixels.at(static_cast<int>(std::lround(kFirst + kSize * column)),
                                   static_cast<int>(std::lround(kFirst + kSize * row))));
      }
    }
    zoomed.frame.pixels = Image2d<std::uint8_t>(80, 80, std::move(larger));
    zoomed.frame.grid.origin_mm = scene().frames[i].frame.grid.at(kFirst, kFirst).mm.head<2>();
    zoomed.frame.grid.mm_per_pixel *= kSize;
    const auto update = live.update(zoomed);
    ASSERT_TRUE(update) << i << ": " << update.error().message;
    EXPECT_EQ(update->state, LiveState::kFollowing) << i;
  }
}

TEST(LiveRegistrationTest, AnotherPatientIsNotFollowedSilently) {
  test::BlobPatient other(99, 150);
  test::SweepSpec spec;
  spec.frames = 25;
  spec.step_mm = 1;
  spec.size_px = 80;
  const Sweep sweep = test::blob_sweep(other, spec);
  LiveOptions options;
  options.max_cost = 0.4;  // These images have less noise than real ones. Correct poses have a cost
                           // of 0.2.
  auto live = start(options);
  int following = 0;
  for (const auto& image : sweep.frames()) {
    const auto update = live.update(image);
    ASSERT_TRUE(update);
    following += update->state == LiveState::kFollowing ? 1 : 0;
  }
  EXPECT_LT(following, 5);
}

TEST(LiveRegistrationTest, ToleratesSaturationRepeatedImagesAndDistantOrigins) {
  auto live = start({});
  double worst = 0;
  for (std::size_t i = 0; i < scene().frames.size(); ++i) {
    TrackedImage image = scene().frames[i];
    if (i % 3 == 1) {  // A saturated image.
      std::vector<std::uint8_t> grey;
      for (const auto v : image.frame.pixels.pixels()) {
        grey.push_back(static_cast<std::uint8_t>(std::min(255, 2 * v)));
      }
      image.frame.pixels = Image2d<std::uint8_t>(80, 80, std::move(grey));
    }
    const auto update = live.update(image);
    ASSERT_TRUE(update);
    ASSERT_TRUE(update->ct_from_reference.translation_mm().allFinite());
    worst = std::max(worst, error_mm(image, update->ct_from_reference, test::true_pose()));
  }
  EXPECT_LT(worst, 3.2);
  EXPECT_FALSE(live.update(scene().frames.back())) << "the same time again";

  // A tracker ten metres away gives the same result.
  const Transform<Reference, Reference> far(Eigen::Quaterniond::Identity(), {1e4, -1e4, 1e4});
  auto near_live = start({});
  auto far_live = start({}, test::true_pose() * far.inverse());
  for (std::size_t i = 0; i < 20; ++i) {
    const auto a = near_live.update(scene().frames[i]);
    const auto b = far_live.update(carried(scene().frames[i], far));
    ASSERT_TRUE(a && b);
    const auto p = scene().frames[i].reference_from_image * scene().frames[i].frame.grid.at(40, 40);
    EXPECT_LE(((a->ct_from_reference * p).mm - (b->ct_from_reference * (far * p)).mm).norm(),
              kStopMm);
  }
}

TEST(LiveRegistrationTest, ResultDoesNotDependOnTheNumberOfThreads) {
  LiveOptions two;
  two.threads = 2;
  auto a = start({});
  auto b = start(two);
  for (std::size_t i = 0; i < 10; ++i) {
    const auto one = a.update(scene().frames[i]);
    const auto other = b.update(scene().frames[i]);
    ASSERT_TRUE(one && other);
    EXPECT_EQ(one->ct_from_reference.translation_mm(), other->ct_from_reference.translation_mm());
  }
}

TEST(LiveRegistrationTest, RejectsOptionsOutOfRange) {
  LiveOptions options;
  options.wander_mm = std::nan("");
  EXPECT_FALSE(validate(options));
  options = {};
  options.window = 0;
  EXPECT_FALSE(LiveRegistration::create(scene().ct, test::true_pose(), options));
  options = {};
  options.jump_mm = options.drift_mm;
  EXPECT_FALSE(validate(options));
}

}  // namespace
}  // namespace nav::registration
