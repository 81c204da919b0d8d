// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/procedure.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"
#include "tests/support/trials.hpp"

namespace nav::sim {
namespace {

using frames::Image;
using Vec = Eigen::Vector3d;

constexpr double kRoundingMm = 1e-9;
constexpr double kRoundingRad = 1e-7;

ProcedureOptions seeded(std::uint64_t seed) {
  ProcedureOptions options;
  options.seed = seed;
  return options;
}

TEST(ProcedureTest, TheTransformChainThroughTheTrackerGivesTheTruth) {
  const Procedure p(seeded(3));
  for (const int frame : {0, 17, 59, 60, 99}) {
    const Timestamp t = p.frame_time(frame);
    const auto reference_from_tracker = p.tracker_from_reference(t).inverse();
    const auto chain = p.ct_from_reference() * reference_from_tracker * p.tracker_from_probe(t) *
                       p.probe_from_image();
    EXPECT_TRUE(test::is_near(chain, p.ct_from_image(t), kRoundingMm, kRoundingRad));
    const auto needle = p.ct_from_reference() * reference_from_tracker * p.tracker_from_needle(t);
    EXPECT_TRUE(test::is_near(needle, p.ct_from_needle(t), kRoundingMm, kRoundingRad));
  }
  EXPECT_GT(p.tracker_from_reference(p.end()).translation_mm().norm(), 1200);
  EXPECT_GT(p.probe_from_image().rotation().angularDistance(Eigen::Quaterniond::Identity()), 0.5);
}

TEST(ProcedureTest, TheSweepImagesTheLiverFromTheSkin) {
  for (std::uint64_t seed = 1; seed <= test::trials(4U); ++seed) {
    const Procedure p(seeded(seed));
    double share = 0;
    const int frames = p.phases()[0].frame_count;
    for (int i = 0; i < frames; ++i) {
      const auto pose = p.ct_from_image(p.frame_time(i));
      // The probe is pressed in by 8 mm, plus or minus the tremor.
      EXPECT_NEAR(p.phantom().skin_distance_mm({pose.translation_mm()}), -8, 2) << i;
      int liver = 0;
      constexpr int kPoints = 24;
      for (int k = 0; k < kPoints; ++k) {
        const Point<Image> at{{0, 15 + 85.0 * k / kPoints, 0}};
        liver += p.phantom().liver_distance_mm(pose * at) < 0 ? 1 : 0;
      }
      share += static_cast<double>(liver) / kPoints / frames;
    }
    EXPECT_GT(share, 0.5) << "seed " << seed;
  }
}

TEST(ProcedureTest, TheProbeMovesSmoothly) {
  const Procedure p(seeded(2));
  const auto step = std::chrono::milliseconds(10);
  for (Timestamp t = p.phases()[0].begin; t < p.end(); t += step) {
    const auto a = p.ct_from_image(t);
    const auto b = p.ct_from_image(t + step);
    // At most 400 mm/s and 2.5 rad/s: a quick hand, but no jump.
    ASSERT_LT((a.translation_mm() - b.translation_mm()).norm(), 4.0) << to_seconds(t);
    ASSERT_LT(rotation_distance_rad(a, b), 0.025) << to_seconds(t);
  }
}

TEST(ProcedureTest, TheNeedleFollowsThePlanFromOutsideToTheTarget) {
  for (std::uint64_t seed = 1; seed <= test::trials(8U); ++seed) {
    const Procedure p(seeded(seed));
    const auto start = p.ct_from_needle(p.phases()[1].begin);
    EXPECT_GT(p.phantom().skin_distance_mm({start.translation_mm()}), 10);
    const NeedleGuidance guidance = guide(p.plan(), p.ct_from_needle(p.end()));
    EXPECT_LT(guidance.tip_to_target_mm, kRoundingMm);
    EXPECT_LT(guidance.angle_to_plan_rad, kRoundingRad);
    // Inside the patient, the tip stays on the planned line.
    for (int i = p.phases()[1].first_frame; i < p.frame_count(); ++i) {
      const auto tip = p.ct_from_needle(p.frame_time(i));
      if (p.phantom().skin_distance_mm({tip.translation_mm()}) > 0) continue;
      EXPECT_LT(guide(p.plan(), tip).lateral_mm, 1e-6);
    }
  }
}

TEST(ProcedureTest, TheApproachPlaneContainsThePath) {
  for (std::uint64_t seed = 1; seed <= test::trials(8U); ++seed) {
    const Procedure p(seeded(seed));
    const auto image_from_ct = p.ct_from_image(p.end()).inverse();
    const auto target = image_from_ct * p.plan().target_ct;
    const auto entry = image_from_ct * p.plan().entry_ct;
    // Tremor of 0.3 mm per axis, and 4 mrad over 100 mm.
    EXPECT_LT(std::abs(target.mm.z()), 1.2) << "seed " << seed;
    EXPECT_LT(std::abs(entry.mm.z()), 1.2) << "seed " << seed;
    EXPECT_LT(std::abs(target.mm.x()), 2);
    EXPECT_LT(entry.mm.x(), target.mm.x() - 15);
  }
}

TEST(ProcedureTest, RejectsInvalidOptions) {
  ProcedureOptions options;
  options.image_timing.stamp_offset = options.image_timing.latency + Duration(1);
  EXPECT_THROW(Procedure{options}, Bug);
  options = {};
  options.sweep_frames = 1;
  EXPECT_THROW(Procedure{options}, Bug);
  TrackerModel model;
  model.rate_hz = 0;
  EXPECT_TRUE(test::rejects(validate(model), ErrorCode::kUsage, {"rate_hz"}));
}

}  // namespace
}  // namespace nav::sim
