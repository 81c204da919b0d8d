// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/stream_timing.hpp"

#include <gtest/gtest.h>

namespace nav::session {
namespace {

Timestamp timing_ms(double ms) { return Timestamp(from_seconds(1e-3 * ms)); }

TEST(StreamTimingTest, GivesRateAndPercentilesOfPeriods) {
  StreamTiming timing;
  EXPECT_EQ(timing.summary().rate_hz, 0);
  // 99 periods of 20 ms, then one of 120 ms.
  for (int i = 0; i < 100; ++i) timing.add(timing_ms(20.0 * i), static_cast<std::uint64_t>(i));
  timing.add(timing_ms(20.0 * 99 + 120), 100);
  const auto found = timing.summary();
  EXPECT_NEAR(found.rate_hz, 100 / 2.1, 1e-9);
  EXPECT_NEAR(found.period_p50_ms, 20, 1e-3);
  EXPECT_NEAR(found.period_p95_ms, 20, 1e-3);
  EXPECT_NEAR(found.period_max_ms, 120, 1e-3);
  EXPECT_EQ(found.missing, 0U);
}

TEST(StreamTimingTest, CountsTheNumbersThatAreLeftOut) {
  StreamTiming timing;
  for (const std::uint64_t number : {5, 6, 9, 10, 10, 3}) timing.add(timing_ms(1), number);
  EXPECT_EQ(timing.summary().missing, 2U) << "7 and 8";
}

TEST(StreamTimingTest, PercentilesAreThoseOfTheNewestPeriods) {
  StreamTiming timing;
  double ms = 0;
  std::uint64_t number = 0;
  for (int i = 0; i < 5000; ++i) timing.add(timing_ms(ms += 10), number++);
  for (int i = 0; i < 3000; ++i) timing.add(timing_ms(ms += 40), number++);
  EXPECT_NEAR(timing.summary().period_p50_ms, 40, 1e-3);
}

}  // namespace
}  // namespace nav::session
