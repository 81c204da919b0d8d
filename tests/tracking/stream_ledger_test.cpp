// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/stream_ledger.hpp"

#include <gtest/gtest.h>

namespace nav::tracking {
namespace {

TEST(StreamLedgerTest, ReceivedIsShownPlusSupersededPlusRejected) {
  StreamLedger ledger;
  for (int i = 0; i < 6; ++i) ledger.receive();
  ledger.deliver();
  ledger.deliver();
  ledger.supersede();
  ledger.reject("Probe.pose_gap");
  ledger.reject("Probe.pose_gap");
  EXPECT_FALSE(ledger.balanced());
  EXPECT_EQ(ledger.waiting(), 1u);
  ledger.reject("no_image");
  EXPECT_TRUE(ledger.balanced());
  EXPECT_EQ(ledger.rejected_total(), 3u);
  EXPECT_EQ(ledger.rejected().at("Probe.pose_gap"), 2u);
}

TEST(StreamLedgerTest, ShowingMoreImagesThanReceivedIsABug) {
  StreamLedger ledger;
  ledger.deliver();
  EXPECT_THROW((void)ledger.balanced(), Bug);
}

}  // namespace
}  // namespace nav::tracking
