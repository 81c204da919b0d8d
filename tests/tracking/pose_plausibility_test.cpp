// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/pose_plausibility.hpp"

#include <gtest/gtest.h>

namespace nav::tracking {
namespace {

RawPose plausible_at(int ms, double x_mm) {
  RawPose pose{Timestamp(std::chrono::milliseconds(ms)), Timestamp(std::chrono::milliseconds(ms)),
               TrackingStatus::kOk, Eigen::Matrix4d::Identity()};
  pose.tracker_from_body(0, 3) = x_mm;
  return pose;
}

class PosePlausibilityTest : public ::testing::Test {
 protected:
  /// The only finding; fails if there is another number.
  Finding only() {
    const auto entries = diagnostics_.entries();
    EXPECT_EQ(entries.size(), 1U);
    return entries.empty() ? Finding{} : *entries[0].finding;
  }
  CollectingDiagnostics diagnostics_;
  PosePlausibility plausibility_{diagnostics_};
};

TEST_F(PosePlausibilityTest, SaysNothingOfBodiesThatMoveInMillimetres) {
  for (int i = 0; i < 100; ++i) {
    plausibility_.add(ToolRole::kProbe, plausible_at(20 * i, 300 + i));
    plausibility_.add(ToolRole::kReference, plausible_at(20 * i, 0.001 * i));
    plausibility_.add(ToolRole::kNeedle, plausible_at(20 * i, 0));
  }
  EXPECT_TRUE(diagnostics_.entries().empty()) << diagnostics_.entries()[0].message;
}

TEST_F(PosePlausibilityTest, NamesPosesInMetresOnce) {
  for (int i = 0; i < 9; ++i)
    plausibility_.add(ToolRole::kProbe, plausible_at(20 * i, 1.2 + 0.01 * i));
  EXPECT_TRUE(diagnostics_.entries().empty()) << "too few to tell";
  for (int i = 9; i < 40; ++i)
    plausibility_.add(ToolRole::kProbe, plausible_at(20 * i, 1.2 + 0.01 * i));
  const Finding found = only();
  EXPECT_EQ(found.subject, "Probe");
  EXPECT_EQ(found.key, "unit of the poses");
  EXPECT_NE(found.values.at(0).find("in metres?"), std::string::npos) << found.values[0];
}

TEST_F(PosePlausibilityTest, NamesPosesInMicrometres) {
  for (int i = 0; i < 5; ++i) plausibility_.add(ToolRole::kNeedle, plausible_at(20 * i, 7e5 + i));
  const Finding found = only();
  EXPECT_EQ(found.subject, "Needle");
  EXPECT_NE(found.values.at(0).find("in micrometres?"), std::string::npos) << found.values[0];
}

TEST_F(PosePlausibilityTest, NamesTwoBodiesWithTheSamePoses) {
  for (int i = 0; i < 5; ++i) {
    plausibility_.add(ToolRole::kProbe, plausible_at(20 * i, 100 + i));
    plausibility_.add(ToolRole::kReference, plausible_at(20 * i + 5, 100 + i));
  }
  const Finding found = only();
  EXPECT_EQ(found.subject, "Probe and Reference");
  EXPECT_EQ(found.key, "poses");
}

TEST_F(PosePlausibilityTest, OneEqualPoseIsNoSign) {
  for (int i = 0; i < 30; ++i) {
    plausibility_.add(ToolRole::kProbe, plausible_at(20 * i, 100 + (i % 3)));
    plausibility_.add(ToolRole::kReference, plausible_at(20 * i, 100));
  }
  EXPECT_TRUE(diagnostics_.entries().empty()) << diagnostics_.entries()[0].message;
}

TEST_F(PosePlausibilityTest, PosesThatTheTrackerDoesNotClaimCountForNothing) {
  for (int i = 0; i < 40; ++i) {
    RawPose pose = plausible_at(20 * i, 0.01 * i);
    pose.status = TrackingStatus::kOccluded;
    plausibility_.add(ToolRole::kProbe, pose);
    plausibility_.add(ToolRole::kReference, pose);
  }
  EXPECT_TRUE(diagnostics_.entries().empty());
}

}  // namespace
}  // namespace nav::tracking
