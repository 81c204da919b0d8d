// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <numbers>

#include "session/navigator.hpp"
#include "sim/fault_plan.hpp"
#include "sim/trackers/sensor_pose_source.hpp"

/// Streams with every fault of FaultPlan pass through gate, buffer, pairing and navigator. What is
/// displayed as live must be correct and recent. Otherwise nothing is displayed as live.
namespace nav {
namespace {

using std::chrono::milliseconds;

constexpr Duration kLength = std::chrono::seconds(20);
constexpr Duration kFramePeriod = milliseconds(50);
/// The probe moves on circles of 60 mm and turns by 0.4 rad at 0.25 Hz. At 94 mm/s, a timestamp
/// that is wrong by 10 ms causes an error of 0.9 mm. Interpolation between samples 20 ms apart has
/// an error below 0.01 mm. Across a gap T of at most 200 ms, the error is at most a g (T - g) / 2,
/// where g is the time to the nearest sample and a = 148 mm/s² or 1 rad/s².
double tolerance_mm(Duration gap) { return 0.05 + 0.5 * 150 * 0.2 * to_seconds(gap); }
double tolerance_rad(Duration gap) { return 5e-4 + 0.5 * 1.1 * 0.2 * to_seconds(gap); }

Transform<frames::Tracker, frames::Probe> probe_at(Timestamp time) {
  const double turn = 2 * std::numbers::pi * 0.25 * to_seconds(time);
  const Eigen::Quaterniond rotation(
      Eigen::AngleAxisd(0.4 * std::sin(turn), Eigen::Vector3d(1, 2, 2).normalized()));
  return {rotation, Eigen::Vector3d(60 * std::cos(turn), 60 * std::sin(turn), 900)};
}
Transform<frames::Tracker, frames::Reference> reference_at(Timestamp) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(1, Eigen::Vector3d::UnitY())), {50, -100, 1100}};
}

class PerfectSensor final : public sim::TrackerSensor {
 public:
  [[nodiscard]] sim::Observation observe(const Eigen::Matrix4d& truth, std::uint64_t,
                                         std::uint64_t) const override {
    return {TrackingStatus::kOk, truth};
  }
  [[nodiscard]] const char* name() const override { return "perfect"; }
};

std::unique_ptr<sim::PoseStream> poses_of(std::function<Eigen::Matrix4d(Timestamp)> truth,
                                          std::uint64_t body) {
  sim::SensorStream stream;
  stream.truth = std::move(truth);
  stream.sensor = std::make_shared<PerfectSensor>();
  stream.begin = Timestamp(milliseconds(0));
  stream.end = Timestamp(kLength);
  stream.body = body;
  return std::make_unique<sim::SensorPoseSource>(stream);
}

/// Source of small images. The sequence number of an image gives its true acquisition time.
class ImageSource final : public sim::ImageStream {
 public:
  static Timestamp physical(std::uint64_t sequence) {
    return Timestamp(milliseconds(200) + static_cast<std::int64_t>(sequence) * kFramePeriod);
  }
  Result<UltrasoundImage> next(Deadline deadline) override {
    const Timestamp acquired = physical(sequence_);
    if (acquired > Timestamp(kLength)) return Error{ErrorCode::kEndOfStream, "end"};
    if (acquired + milliseconds(30) > deadline) return Error{ErrorCode::kTimeout, "later"};
    const auto grey = static_cast<std::uint8_t>(sequence_ % 251);  // No image repeats.
    return UltrasoundImage{.acquired = acquired,
                           .received = acquired + milliseconds(30),
                           .sequence = sequence_++,
                           .pixels = Image2d<std::uint8_t>(2, 2, {1, 2, 3, grey}),
                           .grid = PixelGrid::centred(2, 1, 1)};
  }
  void stop() noexcept override {}

 private:
  std::uint64_t sequence_ = 0;
};

struct Plans {
  sim::FaultPlan probe, reference, frames;
};

struct Outcome {
  int refreshes = 0;
  int live = 0;
  std::map<std::string, std::uint64_t> rejected_poses;
  std::map<std::string, std::uint64_t> rejected_frames;
};

class Session {
 public:
  /// \p judged: true if the values displayed as live must be correct.
  explicit Session(const Plans& plans, bool judged = true)
      : judged_(judged),
        probe_(poses_of([](Timestamp t) { return probe_at(t).matrix(); }, 0), plans.probe, 0),
        reference_(poses_of([](Timestamp t) { return reference_at(t).matrix(); }, 1),
                   plans.reference, 1),
        frames_(std::make_unique<ImageSource>(), plans.frames, 2),
        navigator_(ProbeCalibration{{Eigen::Quaterniond::Identity(), {0, 0, 0}}}, std::nullopt, {},
                   diagnostics_) {}

  Outcome run() {
    const auto ignore = [](const tracking::PairedImage&) {};
    Outcome outcome;
    for (int ms = 0; ms <= 21000; ms += 5) {
      const Timestamp now{milliseconds(ms)};
      deliver(now);
      navigator_.settle(now, false, ignore);
      if (ms % 35 == 0) judge(navigator_.refresh(now), outcome);
    }
    navigator_.settle(Timestamp(milliseconds(21000)), true, ignore);
    navigator_.finish();
    EXPECT_TRUE(navigator_.ledger().balanced());
    outcome.rejected_poses = navigator_.rejected_poses();
    outcome.rejected_frames = navigator_.ledger().rejected();
    return outcome;
  }

 private:
  void deliver(Timestamp now) {
    while (auto pose = probe_.next(now)) navigator_.add_pose(ToolRole::kProbe, *pose);
    while (auto pose = reference_.next(now)) navigator_.add_pose(ToolRole::kReference, *pose);
    while (auto frame = frames_.next(now)) navigator_.add_image(*std::move(frame));
  }

  void judge(const session::Epoch& epoch, Outcome& outcome) const {
    ++outcome.refreshes;
    if (epoch.ultrasound.state != SafetyState::kValid) return;
    ++outcome.live;
    if (!judged_) return;
    ASSERT_TRUE(epoch.frame);
    const Timestamp physical = ImageSource::physical(epoch.frame->frame.sequence);
    EXPECT_LE(epoch.now - physical, milliseconds(100)) << "an old image is shown as live";
    const Transform<frames::Probe, frames::Image> mount(Eigen::Quaterniond::Identity(), {0, 0, 0});
    const auto truth = reference_at(physical).inverse() * probe_at(physical) * mount;
    const auto& shown = epoch.frame->reference_from_image;
    EXPECT_LE((shown.translation_mm() - truth.translation_mm()).norm(),
              tolerance_mm(epoch.frame->pose_gap))
        << "at " << to_seconds(epoch.now) << " s";
    EXPECT_LE(rotation_distance_rad(shown, truth), tolerance_rad(epoch.frame->pose_gap))
        << "at " << to_seconds(epoch.now);
  }

  bool judged_;
  CollectingDiagnostics diagnostics_;
  sim::FaultyPoseSource probe_;
  sim::FaultyPoseSource reference_;
  sim::FaultyImageSource frames_;
  session::Navigator navigator_;
};

Outcome run(const Plans& plans) { return Session(plans).run(); }

using Chance = double sim::FaultPlan::*;
struct Fault {
  const char* name;
  Chance chance;
};
const Fault kFaults[] = {{"drop", &sim::FaultPlan::drop},
                         {"duplicate", &sim::FaultPlan::duplicate},
                         {"reorder", &sim::FaultPlan::reorder},
                         {"future_stamp", &sim::FaultPlan::future_stamp},
                         {"clock_step", &sim::FaultPlan::clock_step},
                         {"stall", &sim::FaultPlan::stall},
                         {"empty", &sim::FaultPlan::empty},
                         {"nan", &sim::FaultPlan::nan},
                         {"flip", &sim::FaultPlan::flip},
                         {"mirror", &sim::FaultPlan::mirror},
                         {"denormalised", &sim::FaultPlan::denormalised}};

TEST(FaultsTest, WithoutFaultsAlmostEveryRefreshIsLive) {
  const Outcome outcome = run({});
  EXPECT_TRUE(outcome.rejected_poses.empty());
  EXPECT_TRUE(outcome.rejected_frames.empty());
  // The first image arrives at 200 ms, the last one at 20 s.
  EXPECT_GT(outcome.live, 0.9 * outcome.refreshes);
}

TEST(FaultsTest, EachFaultOfEachStreamIsRejected) {
  for (const Fault& fault : kFaults) {
    for (sim::FaultPlan Plans::*stream : {&Plans::probe, &Plans::reference, &Plans::frames}) {
      for (const std::uint64_t seed : {1u, 2u}) {
        SCOPED_TRACE(std::string(fault.name) + ", seed " + std::to_string(seed));
        Plans plans;
        (plans.*stream).seed = seed;
        (plans.*stream).*fault.chance = 0.01;
        const Outcome outcome = run(plans);
        EXPECT_GT(outcome.live, 0.3 * outcome.refreshes) << "recovers between faults";
      }
    }
  }
}

TEST(FaultsTest, ClockStepsInBothDirectionsAreRejected) {
  for (sim::FaultPlan Plans::*stream : {&Plans::probe, &Plans::reference, &Plans::frames}) {
    for (const int step_ms : {-1000, -150, -70, 70, 900}) {
      SCOPED_TRACE(step_ms);
      Plans plans;
      (plans.*stream).clock_step = 0.01;
      (plans.*stream).step = milliseconds(step_ms);
      const Outcome outcome = run(plans);
      EXPECT_FALSE(outcome.rejected_poses.empty() && outcome.rejected_frames.empty());
    }
  }
}

TEST(FaultsTest, AllFaultsTogetherAreRejected) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const auto plan = sim::FaultPlan::everything(0.005, seed);
    run({plan, plan, plan});
    // Nobody can detect a clock that is wrong nine times out of ten. In this case the program only
    // must not fail.
    const auto worst = sim::FaultPlan::everything(0.3, seed);
    Session({worst, worst, worst}, false).run();
  }
}

}  // namespace
}  // namespace nav
