// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/placement.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace nav::app {
namespace {

TEST(PlacementTest, SaysWhetherTheUserDeclaredItOrNobodyDid) {
  const auto ct = Volume::create(VoxelGrid{{1, 1, 1}}, {0}, "one voxel");
  SweepSurvey sweep;
  sweep.paired = 1;
  SessionConfig config;
  auto found = place_ct(config, *ct, sweep, "Reference");
  ASSERT_TRUE(test::has_value(found));
  EXPECT_EQ(found->kind, "centred");
  EXPECT_EQ(found->placement.safety.state, SafetyState::kDegraded);
  EXPECT_NE(found->placement.safety.cause.find("centred on the sweep"), std::string::npos);
  EXPECT_EQ(found->placement.safety.cause.find("declaration"), std::string::npos);
  config.placement.ct_from_reference = Eigen::Matrix4d::Identity();
  found = place_ct(config, *ct, sweep, "Reference");
  ASSERT_TRUE(test::has_value(found));
  EXPECT_EQ(found->kind, "declared");
  EXPECT_EQ(found->placement.safety.state, SafetyState::kDegraded);
  EXPECT_NE(found->placement.safety.cause.find("by declaration"), std::string::npos);
}

}  // namespace
}  // namespace nav::app
