// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/arm_file.hpp"

#include <fstream>
#include <gtest/gtest.h>

#include "tests/devices/can_arm_models.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::session {
namespace {

devices::ArmModel arm_with_rest() {
  devices::ArmModel arm = devices::six_joint_arm();
  arm.joints[3].zero_sigma_rad = 1e-4;
  arm.joints[3].link_sigma_mm = 0.05;
  arm.rest = devices::ArmRest{{0.1, -0.2, 0.3, 0, 0, 1}, 0.05};
  return arm;
}

class ArmFileTest : public ::testing::Test {
 protected:
  Result<devices::ArmModel> read(const std::string& text) {
    std::ofstream(file_) << text;
    return read_arm_file(file_);
  }
  std::string error_with(const std::string& from, const std::string& to) {
    std::string text = arm_file_text(arm_with_rest());
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    const auto arm = read(text.replace(at, from.size(), to));
    return arm ? "" : arm.error().message;
  }
  test::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "arm.json";
};

TEST_F(ArmFileTest, IsReadAsItIsWritten) {
  const devices::ArmModel arm = arm_with_rest();
  const auto again = read(arm_file_text(arm));
  ASSERT_TRUE(test::has_value(again));
  ASSERT_EQ(again->joints.size(), arm.joints.size());
  for (std::size_t i = 0; i < arm.joints.size(); ++i) {
    const devices::ArmJoint &one = arm.joints[i], &other = again->joints[i];
    EXPECT_EQ(other.node, one.node);
    EXPECT_EQ(other.counts_per_turn, one.counts_per_turn);
    EXPECT_EQ(other.zero_counts, one.zero_counts);
    EXPECT_EQ(other.reversed, one.reversed);
    EXPECT_EQ(other.previous_from_joint, one.previous_from_joint);
    EXPECT_NEAR(other.zero_sigma_rad, one.zero_sigma_rad, 1e-15);
    EXPECT_EQ(other.link_sigma_mm, one.link_sigma_mm);
  }
  EXPECT_EQ(again->last_from_body, arm.last_from_body);
  ASSERT_TRUE(again->rest);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(again->rest->angles_rad[i], arm.rest->angles_rad[i], 1e-12);
  }
  EXPECT_NEAR(again->rest->tolerance_rad, arm.rest->tolerance_rad, 1e-12);
}

TEST_F(ArmFileTest, NamesTheKeyThatIsWrong) {
  const auto names = [&](const std::string& from, const std::string& to, const std::string& key) {
    const std::string error = error_with(from, to);
    EXPECT_NE(error.find("arm.json." + key), std::string::npos) << to << ": " << error;
  };
  names("\"node\": 1", "\"node\": 1.5", "joints[0].node");
  names("\"node\": 1", "\"node\": 2", "joints[1].node");
  names("\"node\": 1", "\"node\": 300", "joints[0].node");
  names("\"node\": 1", "\"nodes\": 1", "joints[0]");
  names("\"counts_per_turn\": 65536", "\"counts_per_turn\": 4294967296", "joints[0].counts");
  names("\"zero_counts\": 0", "\"zero_counts\": -1", "joints[0].zero_counts");
  names("\"reversed\": false", "\"reversed\": 0", "joints[0].reversed");
  names("\"version\": 1", "\"version\": 2", "version");
  names("\"tolerance_deg\"", "\"tolerance\"", "rest");
  names("\"last_from_body\"", "\"last\"", "last");
  EXPECT_FALSE(read("{}").has_value());
  EXPECT_FALSE(read("[1, 2").has_value());
  EXPECT_FALSE(read_arm_file(folder_ / "none.json").has_value());
}

}  // namespace
}  // namespace nav::session
