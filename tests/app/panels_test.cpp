// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/panels.hpp"

#include <gtest/gtest.h>
#include <vector>

namespace nav::app {
namespace {

constexpr int kWidth = 500;
constexpr int kHeight = 400;

Image2d<Rgba8> composed(const std::string& note, const std::string& warning = "") {
  VoxelGrid grid;
  grid.size = {1, 1, 1};
  const auto ct = Volume::create(grid, {0}, "one voxel");
  const Image2d<Rgba8> view(kWidth, kHeight,
                            std::vector<Rgba8>(std::size_t{kWidth} * kHeight, {40, 40, 40, 255}));
  const Epoch epoch;
  const std::string banner = "SIMULATED";
  return compose_panels(view, {epoch, *ct, {}, {}, banner, {}, note, warning});
}

TEST(PanelsTest, SayWhatTheEngineGaveUpOverThe3dViewAlone) {
  const auto silent = composed("");
  const auto spoken = composed("CT down-sampled to 2 mm");
  ASSERT_EQ(silent.width(), spoken.width());
  int changed = 0;
  for (int y = 0; y < silent.height(); ++y) {
    for (int x = 0; x < silent.width(); ++x) {
      if (silent.at(x, y) == spoken.at(x, y)) continue;
      ++changed;
      EXPECT_TRUE(x < kWidth && y > 20 && y < 60) << x << ", " << y;
    }
  }
  EXPECT_GT(changed, 500);
}

TEST(PanelsTest, SayWhatTheRegistrationIsWarnedOfBelowTheNote) {
  const auto silent = composed("");
  const auto warned = composed("", "registration warned: cost of the match: 0.3");
  int changed = 0;
  for (int y = 0; y < silent.height(); ++y) {
    for (int x = 0; x < silent.width(); ++x) {
      if (silent.at(x, y) == warned.at(x, y)) continue;
      ++changed;
      EXPECT_TRUE(x < kWidth && y >= 50 && y < 80) << x << ", " << y;
    }
  }
  EXPECT_GT(changed, 500);
}

}  // namespace
}  // namespace nav::app
