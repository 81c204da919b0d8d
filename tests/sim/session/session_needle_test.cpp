// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "sim/session/needle_path.hpp"
#include "sim/session/simulated_session.hpp"
#include "tests/support/matchers.hpp"

namespace nav::sim {
namespace {

using ::testing::HasSubstr;
using Vec = Eigen::Vector3d;

SimulatedSessionOptions small(const std::string& family) {
  SimulatedSessionOptions options;
  options.family = family;
  options.probe.columns = 200;
  options.probe.rows = 140;
  options.probe.lines = 96;
  options.duration_s = 1;
  options.frame_rate_hz = 5;
  options.tracker = TrackerKind::kIdeal;
  options.standard_view = true;
  options.needle.emplace();
  options.needle->bending.kind = BendingKind::kBevelArc;
  return options;
}

SimulatedSession session_of(const SimulatedSessionOptions& options) {
  auto session = SimulatedSession::create(options);
  EXPECT_TRUE(session.has_value()) << session.error().message;
  return std::move(*session);
}

TEST(SessionNeedleTest, TheTransformChainOfAnIdealTrackerGivesTheTruth) {
  const auto session = session_of(small("abdomen"));
  auto source = session.needle_poses();
  int count = 0;
  while (const auto raw = source->next(Timestamp::max())) {
    const auto tracker_from_hub =
        rigid_from_matrix<frames::Tracker, NeedleHub>(raw->tracker_from_body);
    ASSERT_TRUE(tracker_from_hub);
    const auto ct_from_needle = session.ct_from_reference() *
                                session.tracker_from_reference().inverse() * *tracker_from_hub *
                                session.needle()->hub_from_needle();
    EXPECT_TRUE(
        test::is_near(ct_from_needle, session.needle()->ct_from_needle(raw->acquired), 1e-8, 1e-7));
    ++count;
  }
  EXPECT_GT(count, 90);
  const ImageTruth last = session.truth(session.frame_count() - 1);
  ASSERT_TRUE(last.needle);
  EXPECT_NEAR(last.needle->inserted_mm, session.needle()->path_mm(), 1e-9);
}

TEST(SessionNeedleTest, EveryTrackerTracksTheHub) {
  for (const auto kind :
       {TrackerKind::kOptical, TrackerKind::kElectromagnetic, TrackerKind::kArm}) {
    SimulatedSessionOptions options = small("abdomen");
    options.tracker = kind;
    for (const std::uint64_t seed : {1u, 2u}) {
      options.seed = seed;
      const auto session = session_of(options);
      auto source = session.needle_poses();
      double worst = 0;
      while (const auto pose = source->next(Timestamp::max())) {
        ASSERT_EQ(pose->status, TrackingStatus::kOk) << to_string(kind) << ' ' << seed;
        const Vec truth = session.tracker_from_hub(pose->acquired).translation_mm();
        worst =
            std::max(worst, (Vec(pose->tracker_from_body.topRightCorner<3, 1>()) - truth).norm());
      }
      EXPECT_GT(worst, 0.01) << to_string(kind);
      EXPECT_LT(worst, 6) << to_string(kind);
    }
  }
}

TEST(SessionNeedleTest, ThePathAvoidsBoneAndGasAndStartsOnTheSkin) {
  for (const PatientFamily& family : patient_families()) {
    const auto patient = family.make({1, Contrast::kPortal});
    const StandardView& view = patient.views.front();
    const auto plan = needle_path(*patient.anatomy, view.ct_from_image, view.probe);
    ASSERT_TRUE(plan) << plan.error().message;
    EXPECT_LE(std::abs(patient.anatomy->skin_distance_mm(plan->entry_ct)), 1.0) << family.name;
    const Vec way = plan->target_ct.mm - plan->entry_ct.mm;
    for (double t = 0; t <= 1; t += 0.01) {
      EXPECT_FALSE(
          blocks_ultrasound(patient.anatomy->tissue({plan->entry_ct.mm + (0.02 + 0.98 * t) * way})))
          << family.name << ' ' << t;
    }
  }
}

/// Mean difference of two images at a list of points.
double difference_along(const UltrasoundImage& a, const UltrasoundImage& b,
                        const Transform<frames::Image, frames::Ct>& pose,
                        const std::vector<Point<frames::Ct>>& chain) {
  double sum = 0;
  for (const auto& p : chain) {
    const Vec image = (pose * p).mm;
    const Eigen::Vector2d at = a.grid.mm_per_pixel.inverse() * (image.head<2>() - a.grid.origin_mm);
    const auto column = static_cast<int>(std::lround(at.x()));
    const auto row = static_cast<int>(std::lround(at.y()));
    sum += std::abs(a.pixels.at(column, row) - b.pixels.at(column, row));
  }
  return sum / static_cast<double>(chain.size());
}

TEST(SessionNeedleTest, ImagesShowTheBentNeedle) {
  for (const auto model : {AcousticModel::kRays, AcousticModel::kScatterers}) {
    SimulatedSessionOptions options = small("abdomen");
    options.probe.model = model;
    const auto patient = make_patient("abdomen", {1, Contrast::kPortal});
    const auto& view = patient->views.front();
    const auto plan = needle_path(*patient->anatomy, view.ct_from_image, options.probe);
    ASSERT_TRUE(plan);
    const UltrasoundSimulator simulator(patient->anatomy, options.probe, 1);
    options.needle->aside_at_target_mm = 8;
    // The needle bends within the image plane: the bevel direction is perpendicular to the axis in
    // the image.
    auto needle =
        NeedleInsertion::create(*plan, *options.needle, Timestamp{}, Timestamp{from_seconds(1)});
    ASSERT_TRUE(needle) << needle.error().message;
    const auto straight_pose = needle->ct_from_needle(Timestamp{from_seconds(1)});
    const Vec normal = (view.ct_from_image * Direction<frames::Image>{Vec::UnitZ()}).v;
    const Vec own = (straight_pose.inverse() * Direction<frames::Ct>{normal}).v;
    options.needle->bending.bevel_rad = std::atan2(own.x(), -own.y());
    needle =
        NeedleInsertion::create(*plan, *options.needle, Timestamp{}, Timestamp{from_seconds(1)});
    const auto shaft = needle->shaft_ct(Timestamp{from_seconds(1)});
    const auto with = simulator.simulate(view.ct_from_image, Timestamp{}, 3, NeedleShaft(shaft));
    const auto without = simulator.simulate(view.ct_from_image, Timestamp{}, 3);
    // The deeper half of the shaft. There the bent shaft is more than 2 mm from the straight line.
    const std::vector<Point<frames::Ct>> deep(shaft.begin(), shaft.begin() + 8);
    std::vector<Point<frames::Ct>> straight;
    for (int i = 0; i < 8; ++i) {
      straight.push_back(straight_pose *
                         Point<frames::Needle>{Vec(0, 0, -i * needle->path_mm() / 16)});
    }
    const auto pose = view.ct_from_image.inverse();
    EXPECT_GT(difference_along(with, without, pose, deep), 8);
    EXPECT_LT(difference_along(with, without, pose, straight), 4);
  }
}

TEST(SessionNeedleTest, RejectsInvalidNeedles) {
  SimulatedSessionOptions options = small("abdomen");
  options.needle->speed_mm_s = -1;
  auto refused = SimulatedSession::create(options);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("speed"));
  options = small("abdomen");
  options.needle->length_mm = 8;
  refused = SimulatedSession::create(options);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("at least the path"));
}

}  // namespace
}  // namespace nav::sim
