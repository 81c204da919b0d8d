// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/recorded_hand.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "sim/anatomy/patient.hpp"
#include "sim/motion/hand_path.hpp"
#include "sim/session/free_view.hpp"
#include "tests/support/matchers.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using frames::Ct;
using frames::Image;
using frames::Reference;

Timestamp second(double seconds) { return Timestamp(from_seconds(seconds)); }

/// A hand that slides 60 mm unevenly across its image, and tilts.
std::vector<RecordedHand::Pose> recorded_poses(int count = 61) {
  const Transform<Reference, Image> first(
      Eigen::Quaterniond(Eigen::AngleAxisd(1.1, Vec(2, -1, 3).normalized())), {400, -30, 90});
  std::vector<RecordedHand::Pose> all;
  for (int i = 0; i < count; ++i) {
    const double share = static_cast<double>(i) / (count - 1);
    const Transform<Image, Image> step(
        Eigen::Quaterniond(Eigen::AngleAxisd(0.3 * std::sin(5 * share), Vec::UnitX())),
        {0, 0, 60 * share * share});
    all.push_back({second(7 + 3 * share), first * step});
  }
  return all;
}

HandPathOptions options_of(const RecordedHand& hand) {
  HandPathOptions options;
  options.recorded = std::make_shared<const RecordedHand>(hand);
  options.begin = second(1);
  options.end = options.begin + hand.duration();
  return options;
}

TEST(RecordedHandTest, APathWithoutSkinMovesAsRecorded) {
  const auto recorded = recorded_poses();
  const auto hand = RecordedHand::create(recorded);
  ASSERT_TRUE(hand.has_value());
  EXPECT_NEAR(to_seconds(hand->duration()), 3, 1e-9);
  const Transform<Ct, Image> middle(Eigen::Quaterniond::Identity(), {5, 6, 7});
  const HandPath path(middle, options_of(*hand));
  const auto first = path.at(second(1));
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    const auto moved = first.inverse() * path.at(second(1) + (recorded[i].time - recorded[0].time));
    const auto expected =
        recorded[0].reference_from_image.inverse() * recorded[i].reference_from_image;
    EXPECT_LE((moved.translation_mm() - expected.translation_mm()).norm(), 1e-6) << i;
    EXPECT_LE(moved.rotation().angularDistance(expected.rotation()), 1e-6) << i;
  }
  // It stays at its ends.
  EXPECT_LE((path.at(second(0)).translation_mm() - first.translation_mm()).norm(), 1e-9);
}

TEST(RecordedHandTest, OnAPatientItStaysAtItsDepthInTheSkin) {
  const auto patient = make_patient("abdomen", {3, Contrast::kPortal});
  ASSERT_TRUE(patient.has_value());
  const double press = press_mm(convex_abdominal());
  const auto middle = free_view(*patient->anatomy, press);
  ASSERT_TRUE(middle.has_value());
  const auto hand = RecordedHand::create(recorded_poses());
  ASSERT_TRUE(hand.has_value());
  const HandPath path(*patient->anatomy, *middle, options_of(*hand));
  const double depth = patient->anatomy->skin_distance_mm({middle->translation_mm()});
  double reach = 0;
  for (double s = 1; s <= 4; s += 0.25) {
    const auto pose = path.at(second(s));
    EXPECT_NEAR(patient->anatomy->skin_distance_mm({pose.translation_mm()}), depth, 0.2) << s;
    reach = std::max(reach, (pose.translation_mm() - middle->translation_mm()).norm());
  }
  EXPECT_GT(reach, 25);  // It slides: most of the way lies to one side of the middle.
}

TEST(RecordedHandTest, RejectsWhatIsNoMotion) {
  auto all = recorded_poses(3);
  const auto rejects = [](const std::vector<RecordedHand::Pose>& wrong, const char* words) {
    const auto hand = RecordedHand::create(wrong);
    ASSERT_FALSE(hand.has_value());
    EXPECT_EQ(hand.error().code, ErrorCode::kMalformedData);
    EXPECT_NE(hand.error().message.find(words), std::string::npos) << hand.error().message;
  };
  rejects({}, "at least 2 poses, found 0");
  rejects({all[0]}, "at least 2 poses, found 1");
  rejects({all[0], all[0]}, "times that increase");
  auto far = all;
  far[2].reference_from_image =
      Transform<Reference, Image>(Eigen::Quaterniond::Identity(), {3000, 0, 0});
  rejects(far, "500 mm");
}

TEST(RecordedHandTest, APathIsNoLongerThanItsRecording) {
  const auto hand = RecordedHand::create(recorded_poses());
  ASSERT_TRUE(hand.has_value());
  HandPathOptions options = options_of(*hand);
  options.end += from_seconds(0.1);
  const auto ok = validate(options);
  ASSERT_FALSE(ok.has_value());
  EXPECT_NE(ok.error().message.find("recorded hand"), std::string::npos);
}

TEST(UnevenPaceTest, GoesFromEndToEndWithinItsBounds) {
  for (const double unevenness : {0.0, 0.3, 0.9}) {
    for (std::uint64_t seed = 1; seed < 20; ++seed) {
      EXPECT_NEAR(uneven_share(0, unevenness, seed), 0, 1e-12);
      EXPECT_NEAR(uneven_share(1, unevenness, seed), 1, 1e-9);
      double slowest = 2, fastest = 0;
      constexpr double kStep = 0.01;
      for (double share = 0; share < 1 - 0.5 * kStep; share += kStep) {
        const double pace = (uneven_share(share + kStep, unevenness, seed) -
                             uneven_share(share, unevenness, seed)) /
                            kStep;
        slowest = std::min(slowest, pace);
        fastest = std::max(fastest, pace);
      }
      EXPECT_GE(slowest, 1 - unevenness - 1e-9);
      EXPECT_LE(fastest, 1 + unevenness + 1e-9);
      EXPECT_GE(fastest - slowest, 0.5 * unevenness);
    }
  }
}

}  // namespace
}  // namespace nav::sim
