// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/reconstruction/fill_holes.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace nav::tracking {
namespace {

/// Slices k = 1 and k = 5 of 8 are seen: 40 and 80.
std::vector<std::int16_t> two_slices() {
  std::vector<std::int16_t> values(5 * 4 * 8, kUnseenVoxel);
  for (std::size_t n = 0; n < 20; ++n) {
    values[20 + n] = 40;
    values[100 + n] = 80;
  }
  return values;
}

TEST(FillHolesTest, InterpolatesBetweenSeenVoxelsAndMarksThem) {
  auto values = two_slices();
  const auto origins = fill_holes({5, 4, 8}, 3, 2, values);
  ASSERT_TRUE(test::has_value(origins));
  for (std::size_t k = 0; k < 8; ++k) {
    for (std::size_t n = 20 * k; n < 20 * (k + 1); ++n) {
      const bool seen = k == 1 || k == 5;
      const bool hole = k > 1 && k < 5;
      EXPECT_EQ((*origins)[n], seen   ? VoxelOrigin::kSeen
                               : hole ? VoxelOrigin::kFilled
                                      : VoxelOrigin::kEmpty);
      EXPECT_EQ(values[n], seen || hole ? 30 + 10 * static_cast<int>(k) : kUnseenVoxel);
    }
  }
}

TEST(FillHolesTest, LeavesLongerHolesAndIsTheSameWithAnyThreads) {
  auto values = two_slices();
  const auto none = fill_holes({5, 4, 8}, 2, 1, values);
  ASSERT_TRUE(test::has_value(none));
  EXPECT_EQ(values, two_slices());
  values[0] = 7;
  auto alone = values;
  const auto one = fill_holes({5, 4, 8}, 3, 1, alone);
  const auto two = fill_holes({5, 4, 8}, 3, 0, values);
  EXPECT_EQ(alone, values);
  EXPECT_EQ(*one, *two);
}

TEST(FillHolesTest, StopsWhenAsked) {
  auto values = two_slices();
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(test::rejects(fill_holes({5, 4, 8}, 3, 1, values, {stop.get_token()}),
                            ErrorCode::kCancelled, {}));
  EXPECT_EQ(values, two_slices());
}

}  // namespace
}  // namespace nav::tracking
