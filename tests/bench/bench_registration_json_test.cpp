// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_registration_json.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace nav::bench {
namespace {

FaultPoint planted() {
  FaultPoint point;
  point.fault = {FaultKind::kDelay, -200};
  point.runs = 20;
  point.solved = 19;
  point.clear = 2;
  point.warned = 3;
  point.refused = 15;
  point.false_accepts = 1;
  point.named = 12;
  point.named_right = 11;
  point.error_mean_mm = 1.5;
  point.error_max_mm = 3.5;
  point.actual_over_predicted = 2.5;
  point.misfits_cpu_ms = 9.5;
  return point;
}

TEST(BenchRegistrationJsonTest, AFaultHasEveryKeyThatIsDocumented) {
  const io::Json rows = json_of(std::vector<FaultPoint>{planted()}, "development");
  const io::Json expected =
      io::Json::parse(R"([{"seeds": "development", "fault": "delay", "size": -200.0,
      "unit": "ms", "runs": 20, "solved": 19, "clear": 2, "warned": 3, "refused": 15,
      "false_accepts": 1, "error_mean_mm": 1.5, "error_max_mm": 3.5, "actual_over_predicted": 2.5,
      "named": 12, "named_right": 11, "misfits_cpu_ms": 9.5}])");
  EXPECT_EQ(rows, expected);
}

TEST(BenchRegistrationJsonTest, WhatNoAcceptedRunSaysIsNull) {
  FaultPoint point = planted();
  point.error_mean_mm = point.error_max_mm = point.actual_over_predicted = NAN;
  const io::Json rows = json_of(std::vector<FaultPoint>{point}, "evaluation");
  ASSERT_EQ(rows.size(), 1U);
  for (const char* key : {"error_mean_mm", "error_max_mm", "actual_over_predicted"}) {
    EXPECT_TRUE(rows[0].at(key).is_null()) << key;
  }
}

TEST(BenchRegistrationJsonTest, StartsHaveEveryKeyThatIsDocumented) {
  StartPoint point{"session rock", true};
  point.sweeps = 4;
  point.registrations = 31;
  point.same = 29;
  point.accepted = 28;
  point.elsewhere = 2;
  point.split = 1;
  point.apart_mm = 0.125;
  point.apart_max_mm = 0.25;
  point.predicted_ratio = 1.5;
  point.predicted_ratio_max = 2.5;
  point.hidden_least_mm = 48;
  point.hidden_most_mm = INFINITY;
  const io::Json expected =
      io::Json::parse(R"([{"path": "session rock", "own_ct": true, "sweeps": 4,
      "registrations": 31, "same": 29, "accepted": 28, "elsewhere": 2, "split": 1, "apart_mm": 0.125,
      "apart_max_mm": 0.25, "predicted_ratio": 1.5, "predicted_ratio_max": 2.5,
      "hidden_least_mm": 48.0, "hidden_most_mm": null}])");
  EXPECT_EQ(json_of(std::vector<StartPoint>{point}), expected);
}

TEST(BenchRegistrationJsonTest, FaultsAreSummedUp) {
  io::Json summary = io::Json::object();
  add_totals({planted(), planted()}, summary);
  EXPECT_EQ(summary.at("fault_runs"), 40);
  EXPECT_EQ(summary.at("fault_false_accepts"), 2);
  add_totals({}, summary);
  EXPECT_TRUE(summary.at("fault_runs").is_null());
  EXPECT_TRUE(summary.at("fault_false_accepts").is_null());
}

}  // namespace
}  // namespace nav::bench
