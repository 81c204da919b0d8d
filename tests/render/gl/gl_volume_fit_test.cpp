// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl/gl_volume_fit.hpp"

#include <gtest/gtest.h>

#include "tests/render/gl/gl_scenes.hpp"

namespace nav::render {
namespace {

TEST(GlVolumeFitTest, FactorsAreTheSmallestThatFit) {
  constexpr std::size_t kEndless = std::size_t{1} << 40;
  EXPECT_EQ(factors_to_fit({512, 300, 1}, 512, kEndless), (std::array<int, 3>{1, 1, 1}));
  EXPECT_EQ(factors_to_fit({513, 300, 1}, 512, kEndless), (std::array<int, 3>{2, 1, 1}));
  EXPECT_EQ(factors_to_fit({2049, 300, 1025}, 512, kEndless), (std::array<int, 3>{5, 1, 3}));
  const auto factors = factors_to_fit({512, 512, 256}, 512, std::size_t{512} * 512 * 256 / 3);
  EXPECT_EQ(factors[0] * factors[1] * factors[2], 4);
}

/// HU are linear in the position, so every mean and interpolation is exact, except where boxes are
/// cut off.
StoredVolume ramp(const std::array<int, 3>& size) {
  VoxelGrid grid = test::oblique_grid();
  grid.size = size;
  std::vector<std::int16_t> hu;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        hu.push_back(static_cast<std::int16_t>(4 * i - 8 * j + 12 * k));
      }
    }
  }
  return *StoredVolume::create(grid, std::move(hu), "ramp");
}

TEST(GlVolumeFitTest, MeansLieInTheMiddleOfTheirBoxes) {
  const StoredVolume full = ramp({12, 8, 9});
  const ReducedVolume small = reduced(full, {2, 4, 3});
  EXPECT_EQ(small.volume->grid().size, (std::array<int, 3>{6, 2, 3}));
  for (int k = 0; k < 3; ++k) {
    const Point<frames::Ct> at = small.volume->grid().at({2.0, 1.0, double(k)});
    EXPECT_NEAR(*full.sample(at), *small.volume->sample(at), 1e-6);
  }
  // Outside the outermost means the values are constant: half a box minus half a voxel along each
  // axis.
  EXPECT_NEAR(small.max_error_hu, 0.5 * 4 + 1.5 * 8 + 1 * 12, 1e-9);
  EXPECT_GT(small.rms_error_hu, 0);
  EXPECT_LT(small.rms_error_hu, small.max_error_hu);
}

TEST(GlVolumeFitTest, AConstantVolumeHasNoError) {
  VoxelGrid grid = test::cube_grid(7, 1.0);
  const StoredVolume full =
      *StoredVolume::create(grid, std::vector<std::int16_t>(grid.voxel_count(), -77), "flat");
  const ReducedVolume small = reduced(full, {2, 2, 2});
  EXPECT_EQ(small.volume->grid().size, (std::array<int, 3>{4, 4, 4}));
  EXPECT_EQ(small.max_error_hu, 0);
  EXPECT_EQ(small.rms_error_hu, 0);
  EXPECT_EQ(note_of(small, full),
            "flat: 7 x 7 x 7 voxels do not fit into this OpenGL device, drawn from means of 2 x 2 "
            "x 2 voxels; values differ by at most 0 HU, rms 0 HU");
}

}  // namespace
}  // namespace nav::render
