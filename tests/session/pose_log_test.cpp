// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/pose_log.hpp"

#include <gmock/gmock.h>

namespace nav::session {
namespace {

tracking::PairedImage paired() {
  UltrasoundImage frame{.acquired = Timestamp(Duration(1500)),
                        .received = Timestamp(Duration(2500)),
                        .sequence = 7,
                        .pixels = Image2d<std::uint8_t>(1, 1, {0}),
                        .grid = PixelGrid::centred(1, 1, 1)};
  return {7,
          TrackedImage{frame,
                       Transform<frames::Reference, frames::Image>(Eigen::Quaterniond(-1, 0, 0, 0),
                                                                   {0.1, -2, -0.0}),
                       Duration(33)},
          ""};
}

TEST(PoseLogTest, WritesOneLinePerImageThatReadsBackExactly) {
  PoseLog log;
  log.add(paired());
  log.add({8, std::nullopt, "Probe.pose_gap"});
  log.add_missing(9, "no_image");
  EXPECT_EQ(log.text(),
            "sequence,acquired_ns,received_ns,outcome,pose_gap_ns,tx_mm,ty_mm,tz_mm,qx,qy,qz,qw\n"
            "7,1500,2500,paired,33,0.1,-2,0,0,0,0,1\n"
            "8,,,Probe.pose_gap,,,,,,,,\n"
            "9,,,no_image,,,,,,,,\n");
}

TEST(PoseLogTest, SaysWhenAPoseIsDegraded) {
  auto frame = paired();
  frame.tracked->doubt = "the tracker gave no status for the probe";
  PoseLog log;
  log.add(frame);
  EXPECT_THAT(log.text(), ::testing::HasSubstr("degraded,33"));
}

}  // namespace
}  // namespace nav::session
