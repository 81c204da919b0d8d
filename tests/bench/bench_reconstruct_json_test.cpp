// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "bench/verbs/bench_reconstruct.hpp"
#include "tests/support/matchers.hpp"

namespace nav::bench {
namespace {

TEST(BenchReconstructJsonTest, EveryMethodHasARateAndAnErrorCurve) {
  const auto report = measure_reconstruction({.quick = true}, [](double) {});
  ASSERT_TRUE(test::has_value(report));
  const io::Json json = json_of(*report);
  EXPECT_EQ(json["rates"].size(), 12U);
  for (const io::Json& rate : json["rates"]) EXPECT_GE(rate["fps_p50"], rate["fps_p95"]);
  EXPECT_GT(json["backward"]["seen"], 1000);
  ASSERT_EQ(json["errors"].size(), 32U);
  for (const io::Json& error : json["errors"]) {
    EXPECT_GT(error["covered"], 0.3) << error;
    EXPECT_GT(error["rms"], 0) << error;
    // A mean of neighbours in small voxels is nearer to an image than its neighbour is.
    if (error["compound"] != "mean" || error["spacing_mm"] > 0.5) continue;
    EXPECT_LT(error["rms"], json["neighbour_rms"]) << error;
  }
}

TEST(BenchReconstructJsonTest, OnlyThePartsAskedForAreMeasured) {
  const auto report = measure_reconstruction(
      {.quick = true, .rates = false, .backward = true, .errors = false}, [](double) {});
  const io::Json json = json_of(*report);
  EXPECT_TRUE(json["rates"].empty());
  EXPECT_TRUE(json["errors"].empty());
  EXPECT_EQ(json["backward"]["images"], 12);
}

}  // namespace
}  // namespace nav::bench
