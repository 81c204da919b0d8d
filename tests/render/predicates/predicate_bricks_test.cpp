// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/skipping/predicate_bricks.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

constexpr int kEdge = 8;  // Voxels. A brick also has the first voxels of its neighbours.

/// Sizes of whole bricks, of one voxel more and less, and of single voxels.
class PredicateBricks : public testing::TestWithParam<std::array<int, 3>> {
 protected:
  [[nodiscard]] Eigen::Vector3i bricks() const {
    const auto& n = GetParam();
    return {(n[0] - 1) / kEdge + 1, (n[1] - 1) / kEdge + 1, (n[2] - 1) / kEdge + 1};
  }
  /// Calls visit(brick, indices of its voxels).
  template <class Visit>
  void for_each_brick(const Visit& visit) const {
    const auto& n = GetParam();
    const Eigen::Vector3i count = bricks();
    for (int b = 0; b < count.prod(); ++b) {
      const std::array<int, 3> at{b % count.x(), b / count.x() % count.y(),
                                  b / count.x() / count.y()};
      std::vector<std::size_t> voxels;
      const auto end = [&](int axis) {
        const auto a = static_cast<std::size_t>(axis);
        return std::min((at[a] + 1) * kEdge + 1, n[a]);
      };
      for (int k = at[2] * kEdge; k < end(2); ++k) {
        for (int j = at[1] * kEdge; j < end(1); ++j) {
          for (int i = at[0] * kEdge; i < end(0); ++i) {
            voxels.push_back(static_cast<std::size_t>((k * n[1] + j) * n[0] + i));
          }
        }
      }
      visit(static_cast<std::size_t>(b), voxels);
    }
  }
};

TEST_P(PredicateBricks, HaveTheRangeOfTheirDefinedVoxels) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> code(-32767, 32767);
  std::uniform_int_distribution<int> percent(0, 99);
  // The first brick has no values. About half of the others have some voxels without a value.
  const auto codes =
      test::make_volume(test::centred_grid(GetParam(), {1, 1, 1}), [&](int i, int j, int k) -> int {
        const bool first = i <= kEdge && j <= kEdge && k <= kEdge;
        const int value = code(random);
        return first || percent(random) == 0 ? FeatureVolume::kUndefined : value;
      });
  for (const int threads : {1, 2}) {
    const ChannelBricks found = channel_bricks({.name = "feature",
                                                .codes = codes,
                                                .offset = 0,
                                                .scale = 1,
                                                .quantum = 1,
                                                .has_undefined = true},
                                               threads);
    ASSERT_EQ(found.range.count, bricks());
    for_each_brick([&](std::size_t b, const std::vector<std::size_t>& voxels) {
      int low = std::numeric_limits<std::int16_t>::max();
      int high = std::numeric_limits<std::int16_t>::min();
      int undefined = 0;
      for (const std::size_t v : voxels) {
        const int value = codes->values()[v];
        if (value == FeatureVolume::kUndefined) {
          undefined = 1;
          continue;
        }
        low = std::min(low, value);
        high = std::max(high, value);
      }
      EXPECT_EQ(found.range.low[b], low) << b;
      EXPECT_EQ(found.range.high[b], high) << b;
      EXPECT_EQ(found.undefined[b], undefined) << b;
    });
    EXPECT_GT(found.range.low[0], found.range.high[0]);
  }
}

TEST_P(PredicateBricks, HaveTheLabelsOfAnyAndOfAllVoxels) {
  std::mt19937 random(8);
  const VoxelGrid grid = test::centred_grid(GetParam(), {1, 1, 1});
  std::vector<std::uint32_t> bits(grid.voxel_count());
  for (std::uint32_t& b : bits) b = (1U << (random() % 32)) | 0x80000001U;
  const auto labels = *LabelVolume::create(grid, bits, "labels");
  for (const int threads : {1, 2}) {
    const LabelBricks found = label_bricks(labels, threads);
    for_each_brick([&](std::size_t b, const std::vector<std::size_t>& voxels) {
      std::uint32_t any = 0;
      std::uint32_t all = ~0U;
      for (const std::size_t v : voxels) {
        any |= bits[v];
        all &= bits[v];
      }
      EXPECT_EQ(found.any[b], any) << b;
      EXPECT_EQ(found.all[b], all) << b;
    });
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, PredicateBricks,
                         testing::Values(std::array{1, 1, 1}, std::array{8, 9, 10},
                                         std::array{17, 16, 1}, std::array{33, 7, 18},
                                         std::array{2, 25, 24}));

}  // namespace
}  // namespace nav::render
