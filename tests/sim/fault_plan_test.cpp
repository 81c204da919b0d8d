// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/fault_plan.hpp"

#include <gtest/gtest.h>
#include <set>
#include <string>

namespace nav::sim {
namespace {

using std::chrono::milliseconds;

/// Delivers a pose every 20 ms, received 5 ms later. Its x translation counts the poses.
class CountingSource final : public PoseStream {
 public:
  explicit CountingSource(int count) : count_(count) {}
  Result<RawPose> next(Deadline deadline) override {
    if (i_ >= count_) return Error{ErrorCode::kEndOfStream, "end"};
    const Timestamp acquired(milliseconds(20 * i_));
    if (acquired + milliseconds(5) > deadline) return Error{ErrorCode::kTimeout, "later"};
    RawPose pose{acquired, acquired + milliseconds(5), TrackingStatus::kOk,
                 Eigen::Matrix4d::Identity()};
    pose.tracker_from_body(0, 3) = i_++;
    return pose;
  }
  void stop() noexcept override {}

 private:
  int count_;
  int i_ = 0;
};

std::vector<RawPose> run(const FaultPlan& plan, std::vector<FaultRecord>* faults = nullptr) {
  FaultyPoseSource source(std::make_unique<CountingSource>(2000), plan);
  std::vector<RawPose> poses;
  while (auto pose = source.next(Timestamp::max())) poses.push_back(*pose);
  if (faults != nullptr) *faults = source.faults();
  return poses;
}

TEST(FaultPlanTest, AnEmptyPlanChangesNothing) {
  const auto poses = run({});
  ASSERT_EQ(poses.size(), 2000u);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(poses[i].tracker_from_body(0, 3), static_cast<double>(i));
    EXPECT_EQ(poses[i].received - poses[i].acquired, milliseconds(5));
  }
}

TEST(FaultPlanTest, ReadsRatesFromTextByName) {
  const auto all = FaultPlan::from("0.25", 3);
  ASSERT_TRUE(all);
  EXPECT_EQ(all->drop, 0.25);
  EXPECT_EQ(all->denormalised, 0.25);
  EXPECT_EQ(all->seed, 3u);
  const auto one = [](const std::string& name) {
    const auto plan = FaultPlan::from(name + "=0.5", 1);
    EXPECT_TRUE(plan) << name;
    std::vector<FaultRecord> faults;
    if (plan) run(*plan, &faults);
    std::set<std::string> kinds;
    for (const auto& fault : faults) kinds.insert(to_string(fault.kind));
    return kinds;
  };
  for (int k = 0; k <= static_cast<int>(FaultKind::kDenormalised); ++k) {
    const std::string name = to_string(static_cast<FaultKind>(k));
    EXPECT_EQ(one(name), std::set<std::string>{name});
  }
  const auto two = FaultPlan::from("drop=0.1,nan=1", 1);
  ASSERT_TRUE(two);
  EXPECT_EQ(two->drop, 0.1);
  EXPECT_EQ(two->nan, 1);
  EXPECT_EQ(two->flip, 0);
}

TEST(FaultPlanTest, RejectsInvalidText) {
  for (const char* text : {"", "nonsense", "drop", "drop=", "drop=2", "drop=-0.1", "drop=0.1,",
                           "drop=0.1x", "dropp=0.1", "nan", "2", "drop=nan"}) {
    const auto refused = FaultPlan::from(text, 1);
    ASSERT_FALSE(refused) << text;
    EXPECT_NE(refused.error().message.find("denormalised"), std::string::npos) << text;
  }
}

TEST(FaultPlanTest, DropsBurstsOfTheStatedLength) {
  FaultPlan plan;
  plan.drop = 0.02;
  plan.drop_samples = 5;
  std::vector<FaultRecord> faults;
  const auto poses = run(plan, &faults);
  EXPECT_NEAR(static_cast<double>(faults.size()), 2000 * 0.02 / (1 + 4 * 0.02), 15);
  EXPECT_EQ(poses.size(), 2000 - 5 * faults.size());
}

TEST(FaultPlanTest, EachFaultHasItsEffectAndIsRecorded) {
  const auto once = [](double FaultPlan::*chance) {
    FaultPlan plan;
    plan.*chance = 0.05;
    return plan;
  };
  std::vector<FaultRecord> faults;
  auto poses = run(once(&FaultPlan::duplicate), &faults);
  EXPECT_EQ(poses.size(), 2000 + faults.size());

  poses = run(once(&FaultPlan::reorder), &faults);
  std::size_t backwards = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    backwards += poses[i].acquired < poses[i - 1].acquired ? 1 : 0;
  }
  EXPECT_EQ(poses.size(), 2000u);
  EXPECT_NEAR(static_cast<double>(backwards), static_cast<double>(faults.size()), 1);

  poses = run(once(&FaultPlan::future_stamp), &faults);
  std::size_t future = 0;
  for (const auto& p : poses) future += p.acquired > p.received ? 1 : 0;
  EXPECT_EQ(future, faults.size());

  poses = run(once(&FaultPlan::nan), &faults);
  std::size_t nan = 0;
  for (const auto& p : poses) nan += p.tracker_from_body.allFinite() ? 0 : 1;
  EXPECT_EQ(nan, faults.size());

  poses = run(once(&FaultPlan::flip), &faults);
  std::size_t flipped = 0;
  for (const auto& p : poses) {
    const double trace = p.tracker_from_body.topLeftCorner<3, 3>().trace();
    EXPECT_TRUE(std::abs(trace - 3) < 1e-12 || std::abs(trace + 1) < 1e-12);
    flipped += trace < 0 ? 1 : 0;
  }
  EXPECT_EQ(flipped, faults.size());

  poses = run(once(&FaultPlan::mirror), &faults);
  std::size_t mirrored = 0;
  for (const auto& p : poses) {
    mirrored += p.tracker_from_body.topLeftCorner<3, 3>().determinant() < 0 ? 1 : 0;
  }
  EXPECT_EQ(mirrored, faults.size());

  poses = run(once(&FaultPlan::denormalised), &faults);
  std::size_t scaled = 0;
  for (const auto& p : poses) scaled += p.tracker_from_body(1, 1) > 1.01 ? 1 : 0;
  EXPECT_EQ(scaled, faults.size());
  for (const auto& fault : faults) EXPECT_EQ(fault.kind, FaultKind::kDenormalised);
}

TEST(FaultPlanTest, AStallDelaysAllPosesAndDeliversThemInOrder) {
  FaultPlan plan;
  plan.stall = 0.01;
  std::vector<FaultRecord> faults;
  const auto poses = run(plan, &faults);
  ASSERT_EQ(poses.size(), 2000u);
  ASSERT_FALSE(faults.empty());
  Duration longest{0};
  for (std::size_t i = 1; i < poses.size(); ++i) {
    EXPECT_GE(poses[i].received, poses[i - 1].received);
    EXPECT_GT(poses[i].acquired, poses[i - 1].acquired);
    longest = std::max<Duration>(longest, poses[i].received - poses[i - 1].received);
  }
  EXPECT_GE(longest, milliseconds(300));
}

TEST(FaultPlanTest, AClockStepIsUndoneAgain) {
  FaultPlan plan;
  plan.clock_step = 0.01;
  std::vector<FaultRecord> faults;
  std::set<std::int64_t> offsets;
  for (const auto& p : run(plan, &faults)) {
    offsets.insert((p.received - p.acquired) / milliseconds(1));
  }
  EXPECT_EQ(offsets, (std::set<std::int64_t>{5, 5 - 150}));
}

TEST(FaultPlanTest, EqualSeedsGiveEqualFaultsAndDeadlinesHold) {
  const auto plan = FaultPlan::everything(0.02, 7);
  std::vector<FaultRecord> a, b, c;
  const auto first = run(plan, &a);
  const auto second = run(plan, &b);
  ASSERT_EQ(first.size(), second.size());
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].acquired, second[i].acquired);
  run(FaultPlan::everything(0.02, 8), &c);
  EXPECT_NE(a.size(), c.size());

  FaultyPoseSource source(std::make_unique<CountingSource>(50), plan);
  for (int ms = 0; ms < 2000; ms += 7) {
    while (auto pose = source.next(Timestamp(milliseconds(ms)))) {
      EXPECT_LE(pose->received, Timestamp(milliseconds(ms)));
    }
  }
  EXPECT_EQ(source.next(Timestamp::max()).error().code, ErrorCode::kEndOfStream);
}

TEST(FaultPlanTest, RejectsInvalidPlans) {
  FaultPlan plan;
  plan.nan = 1.5;
  EXPECT_FALSE(validate(plan));
  plan = {};
  plan.flip = std::nan("");
  EXPECT_FALSE(validate(plan));
  plan = {};
  plan.step = Duration(0);
  EXPECT_FALSE(validate(plan));
}

}  // namespace
}  // namespace nav::sim
