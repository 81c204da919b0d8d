// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/image_pairer.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace nav::tracking {
namespace {

using frames::Image;
using frames::Probe;
using frames::Reference;
using frames::Tracker;
using std::chrono::milliseconds;

constexpr double kRoundingMm = 1e-9;
constexpr double kRoundingRad = 1e-7;

const Transform<Probe, Image> kProbeFromImage(
    Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX())), {1, 2, 3});
const Transform<Tracker, Reference> kTrackerFromReference(
    Eigen::Quaterniond(Eigen::AngleAxisd(-0.8, Eigen::Vector3d::UnitZ())), {100, 0, -50});

Transform<Tracker, Probe> true_tracker_from_probe(double ms) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())),
          {0.1 * ms, -5, 700}};
}

RawPose raw(const Eigen::Matrix4d& matrix, int acquired_ms, int received_ms) {
  return {Timestamp(milliseconds(acquired_ms)), Timestamp(milliseconds(received_ms)),
          TrackingStatus::kOk, matrix};
}

UltrasoundImage image(std::uint64_t sequence, int acquired_ms, int received_ms) {
  return {.acquired = Timestamp(milliseconds(acquired_ms)),
          .received = Timestamp(milliseconds(received_ms)),
          .sequence = sequence,
          .pixels = Image2d<std::uint8_t>(2, 2, {1, 2, 3, 4}),
          .grid = PixelGrid::centred(2, 0.5, 0.5)};
}

class ImagePairerTest : public ::testing::Test {
 protected:
  ImagePairer make(PairingOptions options = {}) {
    return ImagePairer(ProbeCalibration{kProbeFromImage}, std::nullopt, options, diagnostics_);
  }
  static void feed_poses(ImagePairer& pairer, int from_ms, int to_ms) {
    for (int t = from_ms; t <= to_ms; t += 20) {
      pairer.add_probe_pose(raw(true_tracker_from_probe(t).matrix(), t, t + 15));
      pairer.add_reference_pose(raw(kTrackerFromReference.matrix(), t, t + 15));
    }
  }
  CollectingDiagnostics diagnostics_;
};

TEST_F(ImagePairerTest, GivesAnImageThePoseAtItsTime) {
  auto pairer = make();
  feed_poses(pairer, 0, 100);
  pairer.add_frame(image(7, 50, 60));
  const auto ready = pairer.take_ready(Timestamp(milliseconds(120)));
  ASSERT_EQ(ready.size(), 1u);
  ASSERT_TRUE(ready[0].tracked) << ready[0].cause;
  const auto expected =
      kTrackerFromReference.inverse() * true_tracker_from_probe(50) * kProbeFromImage;
  EXPECT_TRUE(
      test::is_near(ready[0].tracked->reference_from_image, expected, kRoundingMm, kRoundingRad));
  EXPECT_EQ(ready[0].tracked->pose_gap, milliseconds(10));
}

TEST_F(ImagePairerTest, RejectsImagesWhileTheirClockIsShifted) {
  auto pairer = make();
  feed_poses(pairer, 0, 2000);
  for (int i = 0; i < 20; ++i) {
    pairer.add_frame(image(static_cast<std::uint64_t>(i), 100 + 50 * i, 110 + 50 * i));
  }
  pairer.add_frame(image(20, 1100 + 80, 1110));
  pairer.add_frame(image(21, 1250, 1260));
  const auto ready = pairer.take_ready(Timestamp(milliseconds(2020)));
  ASSERT_EQ(ready.size(), 22u);
  EXPECT_TRUE(ready[19].tracked);
  EXPECT_EQ(ready[20].cause, "clock_not_believed");
  EXPECT_TRUE(ready[21].tracked);
}

TEST_F(ImagePairerTest, AnImageThatRepeatsWhileTheProbeMovesIsDegraded) {
  auto pairer = make();
  feed_poses(pairer, 0, 2000);  // The probe moves by 100 mm per second.
  for (int i = 0; i < 10; ++i) {
    UltrasoundImage made = image(static_cast<std::uint64_t>(i), 100 + 50 * i, 110 + 50 * i);
    const bool frozen = i >= 3 && i < 7;
    const auto corner = static_cast<std::uint8_t>(frozen ? 3 : i);
    made.pixels = Image2d<std::uint8_t>(2, 2, {corner, 2, 3, 14});
    pairer.add_frame(std::move(made));
  }
  const auto ready = pairer.take_ready(Timestamp(milliseconds(2020)));
  ASSERT_EQ(ready.size(), 10u);
  for (std::size_t i = 0; i < ready.size(); ++i) {
    ASSERT_TRUE(ready[i].tracked) << ready[i].cause;
    EXPECT_EQ(!ready[i].tracked->doubt.empty(), i > 3 && i < 7) << i;
    EXPECT_EQ(ready[i].tracked->repeats.has_value(), i > 3 && i < 7) << i;
  }
  EXPECT_EQ(ready[6].tracked->repeats, ready[3].tracked->frame.acquired);
  EXPECT_NE(ready[5].tracked->doubt.find("frozen"), std::string::npos);
  ASSERT_EQ(diagnostics_.entries().size(), 1u);
  EXPECT_EQ(diagnostics_.entries()[0].finding->values.at(0), ready[5].tracked->doubt);
}

TEST_F(ImagePairerTest, ImagesThatAlternateWhileTheProbeMovesAreDegraded) {
  auto pairer = make();
  feed_poses(pairer, 0, 2000);
  for (int i = 0; i < 12; ++i) {
    UltrasoundImage made = image(static_cast<std::uint64_t>(i), 100 + 50 * i, 110 + 50 * i);
    const bool alternates = i >= 4 && i < 10;
    const auto corner = static_cast<std::uint8_t>(alternates ? 20 + i % 2 : i);
    made.pixels = Image2d<std::uint8_t>(2, 2, {corner, 2, 3, 14});
    pairer.add_frame(std::move(made));
  }
  const auto ready = pairer.take_ready(Timestamp(milliseconds(2020)));
  ASSERT_EQ(ready.size(), 12u);
  for (std::size_t i = 0; i < ready.size(); ++i) {
    ASSERT_TRUE(ready[i].tracked) << ready[i].cause;
    EXPECT_EQ(!ready[i].tracked->doubt.empty(), i > 5 && i < 10) << i;
  }
  EXPECT_NE(ready[7].tracked->doubt.find("alternates between images"), std::string::npos);
  ASSERT_EQ(diagnostics_.entries().size(), 1u);
}

TEST_F(ImagePairerTest, ImagesWhoseClockWasSetAreDegradedAfterwards) {
  auto pairer = make();
  feed_poses(pairer, 0, 6000);
  for (int i = 0; i < 100; ++i) {
    const int set = i < 40 ? 0 : 90;
    pairer.add_frame(image(static_cast<std::uint64_t>(i), 100 + 50 * i + set, 110 + 50 * i));
  }
  const auto ready = pairer.take_ready(Timestamp(milliseconds(6020)));
  ASSERT_EQ(ready.size(), 100u);
  EXPECT_EQ(ready[39].tracked->doubt.find("clock"), std::string::npos);
  EXPECT_EQ(ready[41].cause, "clock_not_believed");
  ASSERT_TRUE(ready[99].tracked);
  EXPECT_NE(ready[99].tracked->doubt.find("clock"), std::string::npos);
}

TEST_F(ImagePairerTest, AppliesTheTemporalOffsetOnceWithItsSign) {
  PairingOptions options;
  options.temporal_offset = milliseconds(40);  // Timestamps of images are 40 ms late.
  auto pairer = make(options);
  feed_poses(pairer, 0, 200);
  pairer.add_frame(image(1, 140, 150));
  const auto ready = pairer.take_ready(Timestamp(milliseconds(220)));
  ASSERT_TRUE(ready.at(0).tracked);
  const auto expected =
      kTrackerFromReference.inverse() * true_tracker_from_probe(100) * kProbeFromImage;
  EXPECT_TRUE(
      test::is_near(ready[0].tracked->reference_from_image, expected, kRoundingMm, kRoundingRad));
  EXPECT_EQ(ready[0].tracked->frame.acquired, Timestamp(milliseconds(100)));
}

TEST_F(ImagePairerTest, WaitsForThePoseAndGivesUpWithACause) {
  auto pairer = make();
  feed_poses(pairer, 0, 40);
  pairer.add_frame(image(1, 50, 55));
  EXPECT_TRUE(pairer.take_ready(Timestamp(milliseconds(60))).empty());
  feed_poses(pairer, 60, 80);
  EXPECT_EQ(pairer.take_ready(Timestamp(milliseconds(90))).size(), 1u);

  pairer.add_frame(image(2, 500, 505));
  EXPECT_TRUE(pairer.take_ready(Timestamp(milliseconds(755))).empty());
  const auto late = pairer.take_ready(Timestamp(milliseconds(756)));
  ASSERT_EQ(late.size(), 1u);
  EXPECT_FALSE(late[0].tracked);
  EXPECT_EQ(late[0].cause, "Probe.no_pose_yet");
}

TEST_F(ImagePairerTest, LosesNothingAtTheEndOfTheStream) {
  auto pairer = make();
  feed_poses(pairer, 0, 40);
  for (std::uint64_t i = 0; i < 5; ++i) {
    const int t = 10 + 20 * static_cast<int>(i);
    pairer.add_frame(image(i, t, t + 5));
  }
  const auto out = pairer.take_ready(Timestamp(milliseconds(95)), true);
  ASSERT_EQ(out.size(), 5u);
  int paired = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    EXPECT_EQ(out[i].sequence, i) << "order is kept";
    paired += out[i].tracked ? 1 : 0;
    EXPECT_NE(out[i].tracked.has_value(), !out[i].cause.empty());
  }
  EXPECT_EQ(paired, 2);
}

TEST_F(ImagePairerTest, RejectsDuplicateAndBackwardsImages) {
  auto pairer = make();
  feed_poses(pairer, 0, 200);
  pairer.add_frame(image(1, 100, 105));
  pairer.add_frame(image(2, 100, 106));
  pairer.add_frame(image(3, 90, 107));
  pairer.add_frame(image(4, 120, 125));
  const auto out = pairer.take_ready(Timestamp(milliseconds(300)));
  ASSERT_EQ(out.size(), 4u);
  EXPECT_TRUE(out[0].tracked);
  EXPECT_EQ(out[1].cause, "time_not_increasing");
  EXPECT_EQ(out[2].cause, "time_not_increasing");
  EXPECT_TRUE(out[3].tracked);
}

TEST_F(ImagePairerTest, DoesNotInterpolateAcrossAnInvalidPose) {
  auto pairer = make();
  pairer.add_reference_pose(raw(kTrackerFromReference.matrix(), 0, 0));
  pairer.add_reference_pose(raw(kTrackerFromReference.matrix(), 100, 100));
  pairer.add_probe_pose(raw(true_tracker_from_probe(0).matrix(), 0, 0));
  pairer.add_probe_pose(raw(Eigen::Matrix4d::Constant(std::nan("")), 20, 20));
  pairer.add_probe_pose(raw(true_tracker_from_probe(40).matrix(), 40, 40));
  pairer.add_frame(image(1, 30, 31));
  const auto out = pairer.take_ready(Timestamp(milliseconds(50)));
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].cause, "Probe.not_tracked");
  EXPECT_EQ(pairer.probe().ledger().rejected().at("not_rigid"), 1u);
  ASSERT_EQ(diagnostics_.entries().size(), 1u);
  EXPECT_NE(diagnostics_.entries()[0].message.find("nan"), std::string::npos);
}

TEST_F(ImagePairerTest, AcceptsADeclaredFixedReferencePose) {
  ImagePairer pairer(
      ProbeCalibration{kProbeFromImage},
      Transform<Reference, Tracker>(Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()), {},
      diagnostics_);
  pairer.add_probe_pose(raw(true_tracker_from_probe(0).matrix(), 0, 0));
  pairer.add_frame(image(1, 0, 1));
  const auto out = pairer.take_ready(Timestamp(milliseconds(2)));
  ASSERT_EQ(out.size(), 1u);
  ASSERT_TRUE(out[0].tracked);
  EXPECT_LT((out[0].tracked->reference_from_image.matrix() -
             (true_tracker_from_probe(0) * kProbeFromImage).matrix())
                .norm(),
            kRoundingMm);
}

TEST_F(ImagePairerTest, RejectsInvalidOptions) {
  PairingOptions options;
  options.temporal_offset = std::chrono::seconds(11);
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"temporal offset", "11"}));
  options = {};
  options.max_pose_gap = Duration::zero();
  EXPECT_FALSE(validate(options));
}

}  // namespace
}  // namespace nav::tracking
