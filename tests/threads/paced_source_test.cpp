// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/paced_source.hpp"

#include <gtest/gtest.h>
#include <thread>

#include "tests/support/scripted_source.hpp"

namespace nav::session {
namespace {

using std::chrono::milliseconds;
using test::at_ms;
using test::ScriptedSource;

constexpr int kFirstMs = 700;  // The source's own clock began earlier.

std::shared_ptr<Source> poses_every_10_ms(int count) {
  auto source = std::make_shared<ScriptedSource>(ScriptedSource::usual());
  for (int i = 0; i < count; ++i) {
    const int ms = kFirstMs + 10 * i;
    source->add(0, ms, PoseSample{test::pose_at(ms - 4)});
  }
  return source;
}

TEST(PacedSourceTest, MovesAllTimesAlongAndGivesNothingEarly) {
  const MonotonicClock clock;
  PacedSource paced(poses_every_10_ms(20), clock);
  std::optional<Duration> shift;
  for (int i = 0; i < 20; ++i) {
    auto sample = paced.next(Timestamp::max());
    ASSERT_TRUE(sample) << i << ": " << sample.error().message;
    EXPECT_EQ(sample->sequence, static_cast<std::uint64_t>(i));
    const RawPose& pose = std::get<PoseSample>(sample->what).pose;
    const Duration moved = pose.acquired - at_ms(kFirstMs + 10 * i - 4);
    if (!shift) shift = moved;
    EXPECT_EQ(moved, *shift);
    EXPECT_EQ(pose.received, sample->received);
    EXPECT_GE(sample->received, at_ms(kFirstMs + 10 * i) + *shift) << "not before its time";
    EXPECT_LE(sample->received, clock.now());
  }
  const auto end = paced.next(Timestamp::max());
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().code, ErrorCode::kEndOfStream);
  EXPECT_EQ(paced.health().state, SourceState::kEnded);
}

TEST(PacedSourceTest, WaitsUntilTheDeadline) {
  const MonotonicClock clock;
  auto source = std::make_shared<ScriptedSource>(ScriptedSource::usual());
  source->add(0, 0, PoseSample{test::pose_at(0)});
  source->add(0, 3'600'000, PoseSample{test::pose_at(3'600'000)});  // In an hour.
  PacedSource paced(source, clock);
  ASSERT_TRUE(paced.next(Timestamp::max()));
  const auto nothing = paced.next(clock.now() + milliseconds(5));
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().code, ErrorCode::kTimeout);
  std::jthread stopper([&] { paced.stop(); });
  const auto stopped = paced.next(Timestamp::max());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::kCancelled);
}

TEST(PacedSourceTest, EndsWhileItsSourceHasMoreToGive) {
  const MonotonicClock clock;
  {
    PacedSource paced(poses_every_10_ms(5000), clock);
    ASSERT_TRUE(paced.next(Timestamp::max()));
  }
  {
    PacedSource paced(poses_every_10_ms(10), clock);  // Nobody ever asked.
    paced.stop();
    EXPECT_FALSE(paced.next(Timestamp::max()));
  }
}

}  // namespace
}  // namespace nav::session
