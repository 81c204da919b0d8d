// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/safety.hpp"

#include <gtest/gtest.h>

#include "nav/check.hpp"
#include "nav/diagnostics.hpp"

namespace nav {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

Timestamp ms(int value) { return Timestamp(milliseconds(value)); }

TEST(SafetyTest, TheWorstStateWinsAndNamesItsCause) {
  const Safety all = compose({{SafetyState::kValid, ""},
                              {SafetyState::kStale, "probe is 90 ms old"},
                              {SafetyState::kDegraded, "status unknown"},
                              {SafetyState::kStale, "reference is 95 ms old"}});
  EXPECT_EQ(all.state, SafetyState::kStale);
  EXPECT_EQ(all.cause, "probe is 90 ms old");
  EXPECT_FALSE(all.shows_numbers());
  EXPECT_THROW(compose({}), Bug);
}

TEST(SafetyTest, NumbersAreShownOnlyWhileValid) {
  for (const auto state : {SafetyState::kDegraded, SafetyState::kStale, SafetyState::kLost}) {
    EXPECT_FALSE((Safety{state, "x"}.shows_numbers()));
  }
  EXPECT_TRUE((Safety{SafetyState::kValid, ""}.shows_numbers()));
  EXPECT_EQ(Safety{}.state, SafetyState::kLost) << "nothing received yet is not valid";
}

TEST(FreshnessTest, LimitsDependOnThePeriod) {
  EXPECT_EQ(freshness_limits(milliseconds(10)).stale_after, milliseconds(30));   // One period + 20
                                                                                 // ms.
  EXPECT_EQ(freshness_limits(milliseconds(50)).stale_after, milliseconds(100));  // Two periods.
  EXPECT_EQ(freshness_limits(milliseconds(10)).lost_after, milliseconds(250));
  EXPECT_THROW(freshness_limits(Duration::zero()), Bug);
}

TEST(FreshnessTest, TurnsStaleAndLostOneNanosecondAfterTheLimits) {
  const FreshnessLimits limits = freshness_limits(milliseconds(50));
  const auto state = [&](Duration age) {
    return freshness("probe", ms(1000), ms(1000) + age, limits).state;
  };
  EXPECT_EQ(state(Duration::zero()), SafetyState::kValid);
  EXPECT_EQ(state(limits.stale_after), SafetyState::kValid);
  EXPECT_EQ(state(limits.stale_after + nanoseconds(1)), SafetyState::kStale);
  EXPECT_EQ(state(limits.lost_after), SafetyState::kStale);
  EXPECT_EQ(state(limits.lost_after + nanoseconds(1)), SafetyState::kLost);
}

TEST(FreshnessTest, AFutureTimestampIsDegraded) {
  const Safety safety = freshness("probe", ms(10), ms(9), freshness_limits(milliseconds(50)));
  EXPECT_EQ(safety.state, SafetyState::kDegraded);
  EXPECT_NE(safety.cause.find("future"), std::string::npos);
}

TEST(CollectingDiagnosticsTest, CountsRepeatedMessagesAndBoundsItsMemory) {
  CollectingDiagnostics diagnostics(2);
  for (int i = 0; i < 1000; ++i) diagnostics.report(Severity::kWarning, "gate", "NaN pose");
  diagnostics.report(Severity::kError, "gate", "NaN pose");
  diagnostics.report(Severity::kInfo, "io", "a third text");
  ASSERT_EQ(diagnostics.entries().size(), 2u);
  EXPECT_EQ(diagnostics.entries()[0].count, 1000u);
  EXPECT_EQ(diagnostics.dropped(), 1u);
}

}  // namespace
}  // namespace nav
