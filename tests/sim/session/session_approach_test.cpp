// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "sim/anatomy/abdomen_phantom.hpp"
#include "sim/session/simulated_session.hpp"
#include "sim/simulated_source.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/trials.hpp"

namespace nav::sim {
namespace {

using frames::Ct;
using frames::Image;
using Vec = Eigen::Vector3d;

constexpr double kExactMm = 1e-9;
constexpr double kExactRad = 1e-7;

SimulatedSessionOptions with_approach(std::uint64_t seed) {
  SimulatedSessionOptions options;
  options.seed = seed;
  options.duration_s = 2;
  options.frame_rate_hz = 10;
  options.path.kind = HandPathKind::kTilt;
  options.path.tremor.drift_mm = 0.2;
  options.path.tremor.drift_rad = 0.002;
  options.tracker = TrackerKind::kIdeal;
  options.approach.emplace();
  return options;
}

SimulatedSession made(const SimulatedSessionOptions& options) {
  auto session = SimulatedSession::create(options);
  EXPECT_TRUE(session.has_value()) << session.error().message;
  return std::move(*session);
}

TEST(SessionApproachTest, FollowsTheSweepAfterAPause) {
  const SimulatedSession session = made(with_approach(3));
  ASSERT_EQ(session.phases().size(), 2u);
  const PhaseInterval& sweep = session.phases()[0];
  const PhaseInterval& approach = session.phases()[1];
  EXPECT_EQ(sweep.phase, Phase::kSweep);
  EXPECT_EQ(approach.phase, Phase::kApproach);
  EXPECT_EQ(sweep.frame_count, 21);
  EXPECT_EQ(approach.first_frame, 21);
  EXPECT_EQ(session.frame_count(), 42);
  EXPECT_EQ(approach.begin - sweep.end, std::chrono::seconds(2));
  EXPECT_EQ(session.frame_time(20), sweep.end);
  EXPECT_EQ(session.frame_time(21), approach.begin);
  EXPECT_EQ(session.frame_time(41), approach.end);
}

TEST(SessionApproachTest, TheSourceHasTheProbeAndTheTipInTheirTruePoses) {
  const SimulatedSession session = made(with_approach(3));
  const auto source = source_of(session);
  const auto ct_from_tracker =
      session.ct_from_reference() * session.tracker_from_reference().inverse();
  int probes = 0, needles = 0;
  for (;;) {
    const auto sample = source->next(Timestamp::max());
    if (!sample) break;
    const auto* pose = std::get_if<PoseSample>(&sample->what);
    if (pose == nullptr) continue;
    const ToolRole role = source->streams()[sample->stream].role;
    if (role == ToolRole::kProbe) {
      const auto tracker_from_probe =
          rigid_from_matrix<frames::Tracker, frames::Probe>(pose->pose.tracker_from_body);
      ASSERT_TRUE(tracker_from_probe);
      EXPECT_TRUE(test::is_near(*tracker_from_probe,
                                session.tracker_from_probe(pose->pose.acquired), kExactMm,
                                kExactRad));
      ++probes;
    } else if (role == ToolRole::kNeedle) {
      const auto tracker_from_tip =
          rigid_from_matrix<frames::Tracker, frames::Needle>(pose->pose.tracker_from_body);
      ASSERT_TRUE(tracker_from_tip);
      EXPECT_TRUE(test::is_near(ct_from_tracker * *tracker_from_tip,
                                session.needle()->ct_from_needle(pose->pose.acquired), 1e-8,
                                kExactRad));
      ++needles;
    }
  }
  EXPECT_GT(probes, 300);
  EXPECT_EQ(needles, probes);
  const ImageTruth last = session.truth(session.frame_count() - 1);
  const auto chain =
      ct_from_tracker * session.tracker_from_probe(last.physical) * session.probe_from_image();
  EXPECT_TRUE(test::is_near(chain, last.ct_from_image, 1e-8, kExactRad));
}

TEST(SessionApproachTest, TheSweepImagesTheLiverFromTheSkin) {
  for (std::uint64_t seed = 1; seed <= test::trials(4U); ++seed) {
    const SimulatedSession session = made(with_approach(seed));
    const AbdomenPhantom phantom({seed, Contrast::kPortal});
    double share = 0;
    const int frames = session.phases()[0].frame_count;
    for (int i = 0; i < frames; ++i) {
      const auto pose = session.truth(i).ct_from_image;
      // The probe is pressed in by 8 mm, plus or minus the tremor.
      EXPECT_NEAR(phantom.skin_distance_mm({pose.translation_mm()}), -8, 2) << i;
      int liver = 0;
      constexpr int kPoints = 24;
      for (int k = 0; k < kPoints; ++k) {
        const Point<Image> at{{0, 15 + 85.0 * k / kPoints, 0}};
        liver += phantom.liver_distance_mm(pose * at) < 0 ? 1 : 0;
      }
      share += static_cast<double>(liver) / kPoints / frames;
    }
    EXPECT_GT(share, 0.5) << "seed " << seed;
  }
}

TEST(SessionApproachTest, TheProbeMovesSmoothly) {
  const SimulatedSession session = made(with_approach(2));
  const auto step = std::chrono::milliseconds(10);
  for (Timestamp t = session.phases()[0].begin; t < session.phases()[1].end; t += step) {
    const auto a = session.tracker_from_probe(t);
    const auto b = session.tracker_from_probe(t + step);
    // At most 400 mm/s and 2.5 rad/s: a quick hand, but no jump.
    ASSERT_LT((a.translation_mm() - b.translation_mm()).norm(), 4.0) << to_seconds(t);
    ASSERT_LT(rotation_distance_rad(a, b), 0.025) << to_seconds(t);
  }
}

TEST(SessionApproachTest, TheNeedleFollowsThePlanFromOutsideToTheTarget) {
  for (std::uint64_t seed = 1; seed <= test::trials(8U); ++seed) {
    const SimulatedSession session = made(with_approach(seed));
    const NeedleInsertion& needle = *session.needle();
    EXPECT_EQ(needle.plan().target_ct.mm,
              AbdomenPhantom({seed, Contrast::kPortal}).plan().target_ct.mm);
    for (const PhaseInterval& phase : session.phases()) {
      const auto start = needle.ct_from_needle(phase.begin);
      EXPECT_GT(session.patient().skin_distance_mm({start.translation_mm()}), 10);
      EXPECT_EQ(needle.inserted_mm(phase.begin), 0);
    }
    for (int i = session.phases()[1].first_frame; i < session.frame_count(); ++i) {
      const auto pose = needle.ct_from_needle(session.frame_time(i));
      EXPECT_LT(guide(needle.plan(), pose).lateral_mm, 1e-6);
    }
    const NeedleGuidance guidance =
        guide(needle.plan(), needle.ct_from_needle(session.phases()[1].end));
    EXPECT_LT(guidance.tip_to_target_mm, kExactMm);
    EXPECT_LT(guidance.angle_to_plan_rad, kExactRad);
  }
}

TEST(SessionApproachTest, TheImagePlaneContainsThePath) {
  for (std::uint64_t seed = 1; seed <= test::trials(8U); ++seed) {
    const SimulatedSession session = made(with_approach(seed));
    const NeedlePlan& plan = session.needle()->plan();
    const ImageTruth last = session.truth(session.frame_count() - 1);
    const auto image_from_ct = last.ct_from_image.inverse();
    const auto target = image_from_ct * plan.target_ct;
    const auto entry = image_from_ct * plan.entry_ct;
    // Tremor of 0.2 mm per axis, and 2 mrad over 100 mm.
    EXPECT_LT(std::abs(target.mm.z()), 1.2) << "seed " << seed;
    EXPECT_LT(std::abs(entry.mm.z()), 1.2) << "seed " << seed;
    EXPECT_LT(std::abs(target.mm.x()), 2);
    EXPECT_LT(entry.mm.x(), target.mm.x() - 15);
    for (double t = 0.1; t < 1; t += 0.05) {
      EXPECT_FALSE(blocks_ultrasound(
          session.patient().tissue(last.ct_from_image * Point<Image>{t * target.mm})))
          << "seed " << seed;
    }
  }
}

TEST(SessionApproachTest, EveryFamilyHasAnApproachOrSaysThatThereIsNoView) {
  const std::uint64_t seeds = test::trials(3U);
  std::uint64_t approaches = 0;
  for (const PatientFamily& family : patient_families()) {
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      const Patient patient = *make_patient(family.name, {seed, Contrast::kPortal});
      SimulatedSessionOptions options = with_approach(seed);
      options.probe = patient.views.front().probe;
      options.standard_view = true;
      const auto session = SimulatedSession::create(options, patient);
      if (!session) {
        EXPECT_TRUE(test::rejects(session, ErrorCode::kUsage, {family.name, "expected a view"}));
        continue;
      }
      ++approaches;
      const Point<Ct> tip = session->truth(session->frame_count() - 1).needle->tip_ct;
      EXPECT_LT((tip - session->needle()->plan().target_ct).v.norm(), 1e-6) << family.name;
    }
  }
  EXPECT_GE(approaches, 5 * seeds + 1);
}

/// Mean grey along the last 20 mm of a path to a target.
double grey_along(const UltrasoundImage& frame, const Transform<Ct, Image>& pose,
                  const NeedlePlan& plan) {
  const Vec back = (plan.entry_ct.mm - plan.target_ct.mm).normalized();
  double sum = 0;
  int count = 0;
  for (double mm = 1; mm < 20; mm += 0.5) {
    const Eigen::Vector2d at =
        frame.grid.pixel_of(pose.inverse() * Point<Ct>{plan.target_ct.mm + mm * back});
    sum += frame.pixels.at(static_cast<int>(std::lround(at.x())),
                           static_cast<int>(std::lround(at.y())));
    ++count;
  }
  return sum / count;
}

TEST(SessionApproachTest, ImagesShowTheNeedleInTheApproachAlone) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    SimulatedSessionOptions options = with_approach(seed);
    options.frame_rate_hz = 2;
    options.path.tremor.drift_mm = options.path.tremor.drift_rad = 0;
    const SimulatedSession session = made(options);
    const auto images = session.frames();
    const NeedlePlan& plan = session.needle()->plan();
    double before = 0;
    for (int i = 0; i < session.frame_count(); ++i) {
      const auto frame = images->next(Timestamp::max());
      ASSERT_TRUE(test::has_value(frame));
      if (i == session.phases()[0].frame_count - 1) {
        const UltrasoundSimulator simulator(make_patient("abdomen", {seed})->anatomy, options.probe,
                                            seed);
        const auto bare =
            simulator.simulate(session.truth(i).ct_from_image, Timestamp{}, frame->sequence);
        EXPECT_TRUE(std::ranges::equal(bare.pixels.pixels(), frame->pixels.pixels()));
      }
      const double grey =
          grey_along(*frame, session.truth(session.frame_count() - 1).ct_from_image, plan);
      if (i == session.phases()[1].first_frame) before = grey;
      if (i == session.frame_count() - 1) {
        EXPECT_GT(grey, before + 30) << "seed " << seed;
      }
    }
  }
}

TEST(SessionApproachTest, RejectsInvalidOptions) {
  SimulatedSessionOptions options = with_approach(1);
  options.approach->pause_s = 0;
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"pause"}));
  options.approach.emplace().duration_s = -1;
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"approach of 0 to 3600 s"}));
  options.approach.emplace().duration_s = 0.01;
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"images of the approach"}));
}

}  // namespace
}  // namespace nav::sim
