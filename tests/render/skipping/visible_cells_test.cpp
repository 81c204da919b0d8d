// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/skipping/visible_cells.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "render/skipping/visible_intervals.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

/// A table that is visible at the given values only. They are far from each other.
TransferTable table_of(const std::vector<int>& hus) {
  std::vector<TransferNode> nodes;
  for (const int hu : hus) {
    nodes.push_back({hu - 3.0, {1, 1, 1}, 0, 1});
    nodes.push_back({double(hu), {1, 1, 1}, 0.5, 1});
    nodes.push_back({hu + 3.0, {1, 1, 1}, 0, 1});
  }
  return TransferTable(*TransferFunction::create("bars", nodes));
}

class Cells {
 public:
  Cells(const StoredVolume& ct, const TransferTable& table, int edge)
      : ct_(ct), layout_(ct, 1), cells_(make(ct, layout_, table, edge)) {}

  [[nodiscard]] bool at(int i, int j, int k) const {
    const int offset = k * layout_.slice_stride() + j * layout_.row_stride() + i;
    return (cells_.words()[offset / 32] >> (offset % 32) & 1) != 0;
  }
  [[nodiscard]] std::size_t count() const { return cells_.count(); }

  /// The definition: the range of the eight voxels of a cell.
  [[nodiscard]] bool expected(const TransferTable& table, int i, int j, int k) const {
    const auto& n = ct_.grid().size;
    int low = 32767;
    int high = -32768;
    for (int corner = 0; corner < 8; ++corner) {
      const int hu =
          ct_.at(std::min(i + (corner & 1), n[0] - 1), std::min(j + (corner >> 1 & 1), n[1] - 1),
                 std::min(k + (corner >> 2), n[2] - 1));
      low = std::min(low, hu);
      high = std::max(high, hu);
    }
    return table.visible(low, high);
  }

 private:
  static VisibleCells make(const StoredVolume& ct, const CpuVolume& layout,
                           const TransferTable& table, int edge) {
    return {ct, layout, brick_distances(make_brick_grid(ct, 1), table), table, edge, 2};
  }

  const StoredVolume& ct_;
  CpuVolume layout_;
  VisibleCells cells_;
};

/// Smooth, so that many bricks are empty, with noise in some bricks.
std::shared_ptr<const StoredVolume> hills(std::array<int, 3> size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> noise(-300, 300);
  return test::make_volume(test::centred_grid(size, {1, 1, 1}), [&](int i, int j, int k) {
    return 500 * std::sin(0.13 * i + 0.2 * j) * std::cos(0.11 * k) + (i > 20 ? noise(random) : 0);
  });
}

constexpr std::array<std::array<int, 3>, 6> kSizes = {
    {{40, 17, 24}, {41, 25, 9}, {33, 8, 30}, {70, 19, 1}, {1, 1, 1}, {1, 33, 2}}};

TEST(VisibleCellsTest, ACellIsVisibleIfItsVoxelsSpanAVisibleValue) {
  const std::vector<std::vector<int>> visible = {{400}, {-700, 350}, {-600, -200, 100, 430}};
  for (unsigned seed = 0; seed < kSizes.size(); ++seed) {
    const auto ct = hills(kSizes[seed], seed);
    for (const auto& hus : visible) {
      const TransferTable table = table_of(hus);
      const Cells cells(*ct, table, 1);
      const auto& n = ct->grid().size;
      std::size_t count = 0;
      for (int k = 0; k < n[2]; ++k) {
        for (int j = 0; j < n[1]; ++j) {
          for (int i = 0; i < n[0]; ++i) {
            const bool expected = cells.expected(table, i, j, k);
            ASSERT_EQ(cells.at(i, j, k), expected) << i << ' ' << j << ' ' << k;
            count += expected ? 1 : 0;
          }
        }
      }
      EXPECT_EQ(cells.count(), count);
    }
  }
}

TEST(VisibleCellsTest, AllCellsOfABlockAreVisibleOrNone) {
  const TransferTable table = table_of({-700, 350});
  for (unsigned seed = 0; seed < 2 * kSizes.size(); ++seed) {
    const auto ct = hills(kSizes[seed / 2], seed);
    const int edge = seed % 2 == 0 ? 2 : 4;
    const Cells cells(*ct, table, edge);
    const auto first = [&](int i) { return i / edge * edge; };
    const auto& n = ct->grid().size;
    std::size_t count = 0;
    for (int k = 0; k < n[2]; ++k) {
      for (int j = 0; j < n[1]; ++j) {
        for (int i = 0; i < n[0]; ++i) {
          bool expected = false;
          for (int z = first(k); z < std::min(first(k) + edge, n[2]); ++z) {
            for (int y = first(j); y < std::min(first(j) + edge, n[1]); ++y) {
              for (int x = first(i); x < std::min(first(i) + edge, n[0]); ++x) {
                expected = expected || cells.expected(table, x, y, z);
              }
            }
          }
          ASSERT_EQ(cells.at(i, j, k), expected) << i << ' ' << j << ' ' << k;
          count += expected ? 1 : 0;
        }
      }
    }
    EXPECT_EQ(cells.count(), count);
  }
}

TEST(VisibleCellsTest, MissesNoneOfManyVisibleValues) {
  std::vector<int> hus;
  for (int hu = -700; hu <= 700; hu += 70) hus.push_back(hu);
  const TransferTable table = table_of(hus);
  EXPECT_EQ(visible_intervals(table).size(), hus.size());
  const auto ct = hills({60, 30, 20}, 1);
  const Cells cells(*ct, table, 1);
  for (int k = 0; k < 20; ++k) {
    for (int j = 0; j < 30; ++j) {
      for (int i = 0; i < 60; ++i) {
        ASSERT_LE(cells.expected(table, i, j, k), cells.at(i, j, k)) << i << ' ' << j << ' ' << k;
      }
    }
  }
}

TEST(VisibleIntervalsTest, ContainTheEndsOfTheTable) {
  const TransferTable table(*TransferFunction::create("ends", {{-100, {1, 1, 1}, 0.5, 1},
                                                               {0, {1, 1, 1}, 0, 1},
                                                               {50, {1, 1, 1}, 0, 1},
                                                               {100, {1, 1, 1}, 0.5, 1}}));
  const auto found = visible_intervals(table);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].least_high, -32768);
  EXPECT_EQ(found[0].greatest_low, 0);  // One above the last visible entry, -1 HU.
  EXPECT_EQ(found[1].least_high, 50);
  EXPECT_EQ(found[1].greatest_low, 32767);
  for (int low = -200; low <= 200; low += 7) {
    for (int high = low; high <= 200; high += 5) {
      const bool shows = std::any_of(found.begin(), found.end(), [&](const VisibleInterval& v) {
        return high >= v.least_high && low <= v.greatest_low;
      });
      EXPECT_EQ(shows, table.visible(low, high)) << low << ' ' << high;
    }
  }
}

}  // namespace
}  // namespace nav::render
