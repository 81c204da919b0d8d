// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <map>

#include "bench/verbs/bench_derived.hpp"
#include "tests/support/matchers.hpp"

namespace nav::bench {
namespace {

TEST(BenchDerivedJsonTest, EveryFeatureHasACurveAgainstItsDefinition) {
  DerivedBenchOptions options;
  options.side = 32;
  options.confidence_side = 16;
  options.repeats = {1, 0};
  const auto report = measure_derived(options, [](double) {});
  ASSERT_TRUE(test::has_value(report));
  std::map<std::string, int> points;
  const io::Json json = json_of(*report);
  for (const io::Json& e : json["errors"]) {
    ++points[e["feature"].get<std::string>()];
    EXPECT_GE(e["rms"].get<double>(), 0);
    EXPECT_LE(e["rms"].get<double>(), e["max"].get<double>());
  }
  EXPECT_EQ(points.size(), 9U);
  for (const auto& [feature, count] : points) EXPECT_GE(count, 3) << feature;
  EXPECT_EQ(json["timings"].size(), 9U);
}

TEST(BenchDerivedJsonTest, OnlyTheFeaturesAskedForAreMeasured) {
  DerivedBenchOptions options;
  options.side = 32;
  options.repeats = {1, 0};
  options.features = {"snr", "depth"};
  const io::Json json = json_of(*measure_derived(options, [](double) {}));
  ASSERT_EQ(json["timings"].size(), 1U);
  EXPECT_EQ(json["timings"][0]["feature"], "snr");
  for (const char* key : {"cpu_s", "wall_s", "bytes_per_voxel", "itk", "itk_cpu_s"}) {
    EXPECT_TRUE(json["timings"][0].contains(key)) << key;
  }
  EXPECT_EQ(json["errors"].size(), 8U);
}

}  // namespace
}  // namespace nav::bench
