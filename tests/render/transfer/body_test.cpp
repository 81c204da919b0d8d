// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/body.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

constexpr int kBodyWidth = 64;  // Voxels of 2 mm.
constexpr int kBodySlices = 12;

bool in_body(int i, int j) { return std::hypot(i - 32, j - 26) < 20; }
bool in_lung(int i, int j) { return std::hypot(i - 26, j - 24) < 7; }
bool in_lung_vessel(int i, int j) { return std::hypot(i - 26, j - 24) < 1.5; }
/// A shell of two voxels that touches the body from below.
bool in_table(int, int j) { return j == 45 || j == 46; }
bool in_cable(int i, int j) { return std::hypot(i - 8, j - 8) < 2; }

std::shared_ptr<const Volume> ct_on_a_table() {
  return std::make_shared<const Volume>(*test::make_volume(
      test::centred_grid({kBodyWidth, kBodyWidth, kBodySlices}, {2, 2, 2}), [](int i, int j, int) {
        if (in_lung_vessel(i, j)) return 40;
        if (in_lung(i, j)) return -850;
        if (in_body(i, j)) return 40;
        if (in_table(i, j)) return 100;
        if (in_cable(i, j)) return 900;
        return -1000;
      }));
}

TEST(BodyTest, LosesTheTableAndTheCableAndKeepsTheLung) {
  const auto ct = ct_on_a_table();
  const BodyOnly body = without_table(ct);
  double removed = 0;
  for (int k = 0; k < kBodySlices; ++k) {
    for (int j = 0; j < kBodyWidth; ++j) {
      for (int i = 0; i < kBodyWidth; ++i) {
        const std::size_t at = static_cast<std::size_t>((k * kBodyWidth + j) * kBodyWidth + i);
        const int before = ct->hu()[at];
        const int after = body.ct->hu()[at];
        if (in_body(i, j)) {
          EXPECT_EQ(after, before) << i << " " << j;
        }
        if (after != before) removed += 0.008;
        if (in_cable(i, j)) {
          EXPECT_EQ(after, kAirHu);
        }
        // Near the body a table stays, because its distance is that of skin.
        if (in_table(i, j) && std::hypot(i - 32, j - 26) > 28) {
          EXPECT_EQ(after, kAirHu) << i;
        }
      }
    }
  }
  EXPECT_NEAR(body.removed_ml, removed, 1e-9);
  EXPECT_GT(removed, 5);
}

TEST(BodyTest, ACtInsideTheBodyStaysTheSameObject) {
  const auto inside = std::make_shared<const Volume>(*test::make_volume(
      test::centred_grid({20, 20, 6}, {2, 2, 2}),
      [](int i, int j, int) { return std::hypot(i - 3, j - 3) < 4 ? -900 : 30; }));
  EXPECT_EQ(without_table(inside).ct, inside) << "a lung at the border is no room for a table";
  const auto air = std::make_shared<const Volume>(*test::make_volume(
      test::centred_grid({9, 9, 9}, {2, 2, 2}), [](int, int, int) { return -1000; }));
  EXPECT_EQ(without_table(air).ct, air);
}

}  // namespace
}  // namespace nav::render
