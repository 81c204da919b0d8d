// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_devices.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace nav::bench {
namespace {

TEST(BenchDevicesTest, NoImageOfARecordingWithFaultsIsShownWronglyAsValid) {
  const auto rows = measure_fault_runs({.recordings = 72, .seconds = 8}, [](double) {});
  ASSERT_TRUE(test::has_value(rows));
  EXPECT_EQ(rows->size(), 18U);
  for (const FaultRuns& row : *rows) {
    SCOPED_TRACE(row.fault);
    EXPECT_EQ(row.recordings, 4);
    EXPECT_GT(row.valid, 0.2 * static_cast<double>(row.images));
    EXPECT_EQ(row.wrong, 0U) << row.worst_mm << " mm";
  }
  const FaultRuns all = sum_of(*rows);
  EXPECT_GT(all.good, 2000U);
  // After a jump a tool is not believed for a second, and a clock that was set for two.
  EXPECT_LE(all.withheld, all.good / 50);
  EXPECT_EQ(json_of(*rows)[0]["fault"], "none");
}

TEST(BenchDevicesTest, TheSameSeedGivesTheSameFigures) {
  const FaultRunsOptions options{.recordings = 18, .seconds = 6, .seed = 3};
  const auto once = measure_fault_runs(options, [](double) {});
  const auto again = measure_fault_runs(options, [](double) {});
  ASSERT_TRUE(test::has_value(once));
  ASSERT_TRUE(test::has_value(again));
  EXPECT_EQ(json_of(*once), json_of(*again));
}

TEST(BenchDevicesTest, TheClockModelFollowsDriftAndFindsSteps) {
  const auto rows = measure_clock_runs({.seconds = 120, .steps = 20}, [](double) {});
  ASSERT_TRUE(test::has_value(rows));
  ASSERT_EQ(rows->size(), 6U);
  for (const ClockRuns& row : *rows) {
    SCOPED_TRACE(row.rate_hz);
    SCOPED_TRACE(row.stamp_ms);
    EXPECT_LT(row.error_p95_ms, row.stamp_ms < 0.5 ? 0.1 : 0.7);
    EXPECT_EQ(row.rejected, 0U);
    EXPECT_EQ(row.false_steps, 0);
    EXPECT_GT(row.steps_found, 0.9);
  }
  EXPECT_EQ(json_of(*rows)[0]["rate_hz"], 20);
}

TEST(BenchDevicesTest, EveryCodecUnderstandsWhatItIsGiven) {
  const auto rows = measure_codecs(0.005);
  ASSERT_TRUE(test::has_value(rows));
  EXPECT_EQ(rows->size(), 6U);
  for (const CodecRun& row : *rows) {
    SCOPED_TRACE(row.codec);
    EXPECT_GT(row.bytes, 0U);
    EXPECT_NEAR(row.mb_per_second, 1e-6 * row.per_second * static_cast<double>(row.bytes),
                0.01 * row.mb_per_second);
  }
  EXPECT_EQ(json_of(*rows)[0]["codec"], "openigtlink image");
  EXPECT_TRUE(test::rejects(measure_codecs(0), ErrorCode::kUsage, {"codecs", "0 to 60 s"}));
}

TEST(BenchDevicesTest, TheRecorderLosesNothing) {
  const auto run = measure_recorder(0.3);
  ASSERT_TRUE(test::has_value(run));
  EXPECT_EQ(run->lost, 0U);
  EXPECT_TRUE(run->balanced);
  EXPECT_GT(run->samples, 100U);
  EXPECT_EQ(json_of(*run)["ledger_balanced"], true);
  EXPECT_TRUE(test::rejects(measure_recorder(-1), ErrorCode::kUsage, {"recorder", "3600 s"}));
}

TEST(BenchDevicesTest, RejectsOptionsOutOfRange) {
  EXPECT_TRUE(test::rejects(measure_fault_runs({.recordings = 0}, [](double) {}), ErrorCode::kUsage,
                            {"recordings", "1 or more", "0"}));
  EXPECT_TRUE(test::rejects(measure_fault_runs({.seconds = 1}, [](double) {}), ErrorCode::kUsage,
                            {"seconds", "5 to 600"}));
  EXPECT_TRUE(test::rejects(measure_clock_runs({.seconds = 1}, [](double) {}), ErrorCode::kUsage,
                            {"clock", "60 to 86400"}));
}

}  // namespace
}  // namespace nav::bench
