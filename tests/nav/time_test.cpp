// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/time.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "nav/check.hpp"

namespace nav {
namespace {

TEST(TimeTest, RoundsSecondsToTheNearestNanosecond) {
  EXPECT_EQ(from_seconds(215.102186).count(), 215102186000);
  EXPECT_EQ(from_seconds(-0.25).count(), -250000000);
  EXPECT_EQ(from_seconds(1e-9).count(), 1);
  EXPECT_DOUBLE_EQ(to_seconds(from_seconds(1.7e9 + 0.5)), 1.7e9 + 0.5);
}

TEST(TimeTest, RejectsSecondsThatDoNotFit) {
  EXPECT_FALSE(is_representable_seconds(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(is_representable_seconds(std::numeric_limits<double>::infinity()));
  EXPECT_FALSE(is_representable_seconds(1e10));
  EXPECT_THROW(from_seconds(1e10), Bug);
}

TEST(TimeTest, DifferenceOfTheExtremeTimesDoesNotOverflow) {
  constexpr double kLatest = 4.59e9;  // Year 2115 with the Unix epoch.
  const Timestamp early(from_seconds(-kLatest));
  const Timestamp late(from_seconds(kLatest));
  EXPECT_GT(late - early, Duration::zero());
  EXPECT_DOUBLE_EQ(to_seconds(late - early), 2 * kLatest);
  EXPECT_FALSE(is_representable_seconds(4.7e9));
  EXPECT_FALSE(is_representable_seconds(-4.7e9));
}

TEST(VirtualClockTest, MovesOnlyForwardsAndOnlyWhenAdvanced) {
  VirtualClock clock;
  EXPECT_EQ(clock.now(), Timestamp{});
  clock.advance_to(Timestamp(std::chrono::seconds(3)));
  clock.advance_to(Timestamp(std::chrono::seconds(3)));
  EXPECT_EQ(clock.now(), Timestamp(std::chrono::seconds(3)));
  EXPECT_THROW(clock.advance_to(Timestamp(std::chrono::seconds(2))), Bug);
}

TEST(MonotonicClockTest, NeverRunsBackwards) {
  const MonotonicClock clock;
  Timestamp last = clock.now();
  for (int i = 0; i < 1000; ++i) {
    const Timestamp now = clock.now();
    ASSERT_GE(now, last);
    last = now;
  }
}

}  // namespace
}  // namespace nav
