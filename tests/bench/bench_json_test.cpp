// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_json.hpp"

#include <gtest/gtest.h>

namespace nav::bench {
namespace {

TEST(BenchJsonTest, KeysWithoutMeasurementsAreEmptyOrNull) {
  const io::Json json = json_of(BenchRenderReport{});
  for (const char* key : {"interaction", "skip_bounds"}) {
    ASSERT_TRUE(json.contains(key)) << key;
    EXPECT_EQ(json[key], io::Json::array()) << key;
  }
  for (const char* key : {"transfer_function_edit", "costs"}) {
    ASSERT_TRUE(json.contains(key)) << key;
    EXPECT_TRUE(json[key].is_null()) << key;
  }
  const io::Json& skipping = json["ratios"]["samples_skip_off_over_on"];
  ASSERT_TRUE(skipping.contains("bit_identical"));
  EXPECT_TRUE(skipping["bit_identical"].is_null());
}

TEST(BenchJsonTest, SaysWhetherSkippingChangedTheImage) {
  for (const bool identical : {true, false}) {
    BenchRenderReport report;
    SkipRatio ratio;
    ratio.scene = "v/look/perspective/shaded";
    ratio.identical = identical;
    report.skipping = {ratio};
    SkipBound bound;
    bound.found = ratio;
    report.skip_bounds = {bound};
    const io::Json json = json_of(report);
    EXPECT_EQ(json["ratios"]["samples_skip_off_over_on"]["bit_identical"], identical);
    EXPECT_EQ(json["skip_bounds"][0]["bit_identical"], identical);
  }
}

}  // namespace
}  // namespace nav::bench
