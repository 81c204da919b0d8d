// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/patch_loss.hpp"

#include <gtest/gtest.h>

namespace nav::registration {
namespace {

TEST(PatchLossTest, IsZeroAtZeroOneAtOneAndConcave) {
  for (const PatchLoss kind : {PatchLoss::kNone, PatchLoss::kCauchy, PatchLoss::kGemanMcClure}) {
    for (const double scale : {1e-3, 0.3, 1000.0}) {
      const RobustLoss loss{kind, scale};
      EXPECT_EQ(loss.value(0), 0);
      EXPECT_NEAR(loss.value(1), 1, 1e-12);
      for (double s = 0; s < 1; s += 0.05) {
        EXPECT_GE(loss.value(s), s - 1e-12) << to_string(kind) << ' ' << scale;
        EXPECT_GT(loss.derivative(s), 0);
        EXPECT_GE(loss.derivative(s), loss.derivative(s + 0.05));
        const double h = 1e-6;
        const double slope = (loss.value(s + h) - loss.value(s)) / h;
        EXPECT_NEAR(slope / loss.derivative(s + 0.5 * h), 1, 1e-5) << to_string(kind) << ' ' << s;
      }
    }
  }
}

TEST(PatchLossTest, WithAHugeScaleEveryPatchHasEqualWeight) {
  for (const PatchLoss kind : {PatchLoss::kCauchy, PatchLoss::kGemanMcClure}) {
    const RobustLoss loss{kind, 1000};
    EXPECT_NEAR(loss.value(0.3), 0.3, 1e-3);
    EXPECT_NEAR(loss.derivative(0.9), 1, 2e-3);
  }
}

}  // namespace
}  // namespace nav::registration
