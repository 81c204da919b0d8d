// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/reconstruction/image_path.hpp"

#include <gtest/gtest.h>
#include <random>

#include "tests/tracking/reconstruction/planted_sweep.hpp"

namespace nav::tracking {
namespace {

TEST(ImagePathTest, FindsExactlyTheColumnsInARange) {
  std::mt19937_64 random(3);
  const auto number = [&](std::int64_t most) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(2 * most + 1)) - most;
  };
  for (int trial = 0; trial < 20000; ++trial) {
    const std::int64_t start = number(200);
    const std::int64_t step = number(7);
    const std::int64_t low = number(100);
    const std::int64_t high = low + number(60);
    const ColumnSpan columns{static_cast<int>(random() % 10), 10 + static_cast<int>(random() % 50)};
    const ColumnSpan found = columns_within(columns, start, step, low, high);
    for (int column = columns.first; column < columns.past; ++column) {
      const std::int64_t at = start + column * step;
      ASSERT_EQ(column >= found.first && column < found.past, at >= low && at < high)
          << start << ' ' << step << ' ' << low << ' ' << high << ' ' << column;
    }
  }
}

TEST(ImagePathTest, FollowsThePixelsOfARow) {
  const auto image = test::sweep_of([](const Eigen::Vector3d&) { return 0.0; }, 1).front();
  const auto grid = test::grid_around({image}, 0.5);
  const auto path = ImagePath::of(image, grid, 0.5);
  ASSERT_TRUE(path.has_value());
  for (const int row : {0, 20, 55}) {
    const FixedPosition start = path->row_start(row);
    for (const int column : {0, 1, 63}) {
      const Eigen::Vector3d expected =
          grid.index_of(image.reference_from_image * image.frame.grid.at(column, row)).array() +
          0.5;
      for (std::size_t a = 0; a < 3; ++a) {
        const auto at = static_cast<double>(start[a] + column * path->step()[a]);
        EXPECT_NEAR(std::ldexp(at, -kPositionBits), expected[static_cast<Eigen::Index>(a)], 1e-7);
      }
    }
  }
}

}  // namespace
}  // namespace nav::tracking
