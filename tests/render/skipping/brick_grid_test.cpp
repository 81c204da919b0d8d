// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/skipping/brick_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

constexpr int kAir = -1000;
constexpr int kBone = 900;

std::size_t index_of(const Eigen::Vector3i& count, const Eigen::Vector3i& b) {
  return static_cast<std::size_t>((b.z() * count.y() + b.y()) * count.x() + b.x());
}

Eigen::Vector3i brick_of(const Eigen::Vector3i& count, int at) {
  return {at % count.x(), at / count.x() % count.y(), at / count.x() / count.y()};
}

VoxelGrid grid_of(std::array<int, 3> size) { return test::centred_grid(size, {1, 1, 1}); }

/// Invisible up to 399 HU, visible from 401 HU.
TransferTable bone_table() {
  return TransferTable(*TransferFunction::create(
      "bone", {{-1000, {1, 1, 1}, 0, 0}, {400, {1, 1, 1}, 0, 0}, {600, {1, 1, 1}, 0.5, 0}}));
}

std::shared_ptr<const StoredVolume> noise(const VoxelGrid& grid, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> hu(-32768, 32767);
  return test::make_volume(grid, [&](int, int, int) { return hu(random); });
}

TEST(BrickGridTest, CountsTheBricksOfAllSamples) {
  // A sample exactly at the last voxel n - 1 has its own brick if n = 8 m + 1.
  for (const auto& [voxels, bricks] :
       {std::pair{1, 1}, {2, 1}, {8, 1}, {9, 2}, {10, 2}, {16, 2}, {17, 3}}) {
    const auto grid = make_brick_grid(*noise(grid_of({voxels, 1, 3}), 1), 1);
    EXPECT_EQ(grid.count, Eigen::Vector3i(bricks, 1, 1)) << voxels;
    EXPECT_EQ(grid.low.size(), static_cast<std::size_t>(bricks));
    EXPECT_EQ(grid.high.size(), static_cast<std::size_t>(bricks));
  }
}

TEST(BrickGridTest, RangesContainAllVoxelsThatASampleInTheBrickUses) {
  unsigned seed = 2;
  for (const std::array<int, 3> size :
       {std::array{16, 24, 8}, {17, 9, 25}, {21, 13, 7}, {30, 19, 1}, {1, 1, 1}, {1, 33, 2}}) {
    const auto volume = noise(grid_of(size), seed++);
    const BrickGrid grid = make_brick_grid(*volume, 2);
    for (int at = 0; at < grid.count.prod(); ++at) {
      const Eigen::Vector3i b = brick_of(grid.count, at);
      // Lower voxels 8 b ... 8 b + 7, and the upper neighbour of each, if it exists.
      std::array<int, 3> end{};
      for (int a = 0; a < 3; ++a) {
        const auto axis = static_cast<std::size_t>(a);
        end[axis] = std::min(8 * b(a) + 8, size[axis] - 1);
      }
      std::int16_t low = 32767;
      std::int16_t high = -32768;
      for (int k = 8 * b.z(); k <= end[2]; ++k) {
        for (int j = 8 * b.y(); j <= end[1]; ++j) {
          for (int i = 8 * b.x(); i <= end[0]; ++i) {
            low = std::min(low, volume->at(i, j, k));
            high = std::max(high, volume->at(i, j, k));
          }
        }
      }
      EXPECT_EQ(grid.low[static_cast<std::size_t>(at)], low) << b.transpose();
      EXPECT_EQ(grid.high[static_cast<std::size_t>(at)], high) << b.transpose();
    }
  }
}

TEST(BrickGridTest, AVoxelAtABrickBorderAlsoBelongsToTheBrickBelow) {
  const auto bricks_with_bone = [](const Eigen::Vector3i& bone) {
    const auto volume = test::make_volume(grid_of({24, 24, 24}), [&](int i, int j, int k) {
      return Eigen::Vector3i(i, j, k) == bone ? kBone : kAir;
    });
    const BrickGrid grid = make_brick_grid(*volume, 1);
    std::vector<std::size_t> found;
    for (std::size_t b = 0; b < grid.high.size(); ++b) {
      EXPECT_EQ(grid.low[b], kAir);
      if (grid.high[b] == kBone) found.push_back(b);
    }
    return found;
  };
  const Eigen::Vector3i count(3, 3, 3);
  const auto at = [&](int x, int y, int z) { return index_of(count, {x, y, z}); };
  using Bricks = std::vector<std::size_t>;
  EXPECT_EQ(bricks_with_bone({12, 12, 12}), Bricks{at(1, 1, 1)});
  EXPECT_EQ(bricks_with_bone({16, 12, 12}), (Bricks{at(1, 1, 1), at(2, 1, 1)}));
  EXPECT_EQ(bricks_with_bone({15, 12, 12}), Bricks{at(1, 1, 1)});
  EXPECT_EQ(bricks_with_bone({17, 12, 12}), Bricks{at(2, 1, 1)});
  EXPECT_EQ(bricks_with_bone({12, 8, 12}), (Bricks{at(1, 0, 1), at(1, 1, 1)}));
  EXPECT_EQ(bricks_with_bone({12, 12, 8}), (Bricks{at(1, 1, 0), at(1, 1, 1)}));
  EXPECT_EQ(bricks_with_bone({0, 0, 0}), Bricks{at(0, 0, 0)});
  EXPECT_EQ(bricks_with_bone({8, 8, 8}).size(), 8U);
}

TEST(BrickGridTest, DoesNotDependOnThreads) {
  const auto volume = noise(grid_of({37, 41, 50}), 7);
  const BrickGrid one = make_brick_grid(*volume, 1);
  for (const int threads : {0, 2, 3}) {
    const BrickGrid other = make_brick_grid(*volume, threads);
    EXPECT_EQ(one.count, other.count);
    EXPECT_EQ(one.low, other.low);
    EXPECT_EQ(one.high, other.high);
  }
}

/// Bricks of air, some of bone with the given probability.
BrickGrid random_bricks(std::mt19937& random, const Eigen::Vector3i& count, double bone) {
  std::bernoulli_distribution occupied(bone);
  BrickGrid grid;
  grid.count = count;
  for (int b = 0; b < count.prod(); ++b) {
    grid.low.push_back(kAir);
    grid.high.push_back(static_cast<std::int16_t>(occupied(random) ? kBone : kAir));
  }
  return grid;
}

TEST(BrickDistancesTest, IsTheDistanceToTheNearestOccupiedBrick) {
  std::mt19937 random(8);
  const TransferTable table = bone_table();
  for (const Eigen::Vector3i& count :
       {Eigen::Vector3i(9, 7, 5), {1, 13, 6}, {20, 1, 1}, {8, 8, 8}, {1, 1, 1}, {3, 17, 11}}) {
    for (const double bone : {0.0, 0.01, 0.1, 1.0}) {
      const BrickGrid grid = random_bricks(random, count, bone);
      const BrickDistances found = brick_distances(grid, table);
      std::size_t occupied = 0;
      ASSERT_EQ(found.distance.size(), grid.high.size());
      for (int at = 0; at < count.prod(); ++at) {
        int nearest = 255;
        for (int other = 0; other < count.prod(); ++other) {
          if (grid.high[static_cast<std::size_t>(other)] != kBone) continue;
          const Eigen::Vector3i apart = brick_of(count, at) - brick_of(count, other);
          nearest = std::min(nearest, apart.cwiseAbs().maxCoeff());
        }
        EXPECT_EQ(found.distance[static_cast<std::size_t>(at)], nearest);
        if (nearest == 0) ++occupied;
      }
      EXPECT_EQ(found.occupied, occupied);
    }
  }
}

TEST(BrickDistancesTest, StopsAt255) {
  std::mt19937 random(9);
  BrickGrid grid = random_bricks(random, {600, 1, 1}, 0);
  grid.high[300] = kBone;
  const BrickDistances found = brick_distances(grid, bone_table());
  EXPECT_EQ(found.occupied, 1U);
  for (const auto& [brick, distance] :
       {std::pair{0, 255}, {45, 255}, {46, 254}, {299, 1}, {300, 0}, {554, 254}, {599, 255}}) {
    EXPECT_EQ(found.distance[static_cast<std::size_t>(brick)], distance) << brick;
  }
}

TEST(BrickDepthsTest, IsTheDistanceToTheNearestEmptyBrick) {
  std::mt19937 random(10);
  for (const Eigen::Vector3i& count : {Eigen::Vector3i(9, 7, 5), {17, 1, 3}, {8, 8, 8}}) {
    for (const double bone : {0.3, 0.95, 0.99, 1.0}) {
      const BrickGrid grid = random_bricks(random, count, bone);
      const auto depths = brick_depths(grid, hidden_bricks(grid, bone_table()));
      ASSERT_EQ(depths.size(), grid.high.size());
      for (int at = 0; at < count.prod(); ++at) {
        int nearest = 255;
        for (int other = 0; other < count.prod(); ++other) {
          if (grid.high[static_cast<std::size_t>(other)] == kBone) continue;
          const Eigen::Vector3i apart = brick_of(count, at) - brick_of(count, other);
          nearest = std::min(nearest, apart.cwiseAbs().maxCoeff());
        }
        EXPECT_EQ(depths[static_cast<std::size_t>(at)], nearest);
      }
    }
  }
}

TEST(VisiblePartsTest, MarksPartsWithABrightVoxelThatASampleUses) {
  std::mt19937 random(12);
  std::bernoulli_distribution bone(0.004);
  for (const std::array<int, 3> size :
       {std::array{24, 17, 32}, {9, 5, 13}, {20, 12, 1}, {1, 1, 1}, {33, 4, 8}}) {
    const VoxelGrid voxels = grid_of(size);
    const auto volume =
        test::make_volume(voxels, [&](int, int, int) { return bone(random) ? kBone : kAir; });
    const BrickGrid bricks = make_brick_grid(*volume, 2);
    const auto parts = visible_parts(make_part_grid(*volume, 2), bricks,
                                     hidden_bricks(bricks, bone_table()), bone_table(), 2);
    std::vector<std::uint8_t> expected(bricks.high.size(), 0);
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i) {
          // A sample with this lower voxel uses voxels up to one step further.
          bool bright = false;
          for (int corner = 0; corner < 8; ++corner) {
            const auto next = [&](int axis, int at) {
              return std::min(at + (corner >> axis & 1), size[static_cast<std::size_t>(axis)] - 1);
            };
            bright = bright || volume->at(next(0, i), next(1, j), next(2, k)) == kBone;
          }
          const unsigned bit = static_cast<unsigned>(i / 4 % 2 + j / 4 % 2 * 2 + k / 4 % 2 * 4);
          auto& bits = expected[index_of(bricks.count, {i / 8, j / 8, k / 8})];
          if (bright) bits = static_cast<std::uint8_t>(bits | 1U << bit);
        }
      }
    }
    for (std::size_t b = 0; b < expected.size(); ++b) {
      const bool empty = bricks.high[b] != kBone;
      EXPECT_EQ(parts[b], empty ? 0xFF : expected[b]) << b;
    }
  }
}

/// A few nodes at random values, some invisible, sometimes in a gradient window.
TransferTable random_table(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<TransferNode> nodes;
  double hu = -2000 + 3000 * unit(random);
  for (int i = 0; i < 5; ++i) {
    const double opacity = unit(random) < 0.6 ? 0 : unit(random);
    nodes.push_back({hu, {1, 1, 1}, 0.99 * opacity, unit(random) < 0.3 ? 1.0 : unit(random)});
    hu += 0.1 + 300 * unit(random) * unit(random);
  }
  std::optional<GradientWindow> window;
  if (unit(random) < 0.3) window = GradientWindow{10, 20, 30, 40};
  return TransferTable(*TransferFunction::blend("random", {{"part", nodes, window}}));
}

TEST(BrickClassificationTest, AgreesWithTheRangesOfTheTable) {
  std::mt19937 random(11);
  std::uniform_int_distribution<int> hu(-3000, 3000);
  for (int i = 0; i < 200; ++i) {
    const TransferTable table = random_table(random);
    BrickGrid grid;
    grid.count = {40, 1, 1};
    for (int b = 0; b < 40; ++b) {
      const int low = b < 2 ? -32768 : hu(random);
      grid.low.push_back(static_cast<std::int16_t>(low));
      grid.high.push_back(
          static_cast<std::int16_t>(b == 1 ? 32767 : low + std::abs(hu(random)) / 50));
    }
    const BrickDistances distances = brick_distances(grid, table);
    const auto importance = brick_importance(grid, table);
    for (std::size_t b = 0; b < 40; ++b) {
      EXPECT_EQ(distances.distance[b] == 0, table.visible(grid.low[b], grid.high[b]));
      const double expected = table.max_importance(grid.low[b], grid.high[b]);
      EXPECT_EQ(importance[b], expected < 1 ? std::ceil(254 * expected) : 255);
    }
  }
}

}  // namespace
}  // namespace nav::render
