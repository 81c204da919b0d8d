// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/transfer_editor.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <random>

namespace nav::render {
namespace {

constexpr double kOpacity = 1e-12;

TransferEditor edit_liver() { return TransferEditor(*preset_transfer_function("ct-liver")); }

TEST(TransferEditorTest, AnyEditsLeaveAValidFunctionAndUndoLeadsBack) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  TransferEditor editor = edit_liver();
  const TransferFunction before = editor.function();
  std::size_t edits = 0;
  for (; edits < 90; ++edits) {
    const std::size_t c = below(editor.components().size());
    const std::size_t n = below(editor.components()[c].nodes.size());
    switch (below(4)) {
      case 0:
        editor.move_node(c, n, 4000 * unit(random) - 2000, 2 * unit(random) - 0.5);
        break;
      case 1:
        editor.set_colour(c, {2 * unit(random) - 0.5, unit(random), unit(random)});
        break;
      case 2:
        editor.set_opacity(c, 1.4 * unit(random) - 0.2);
        break;
      default:
        editor.set_importance(c, 1.4 * unit(random) - 0.2);
    }
    // blend() is the validation.
    ASSERT_TRUE(TransferFunction::blend("edited", editor.components()).has_value());
  }
  for (std::size_t i = 0; i < edits; ++i) ASSERT_TRUE(editor.undo());
  EXPECT_FALSE(editor.undo());
  EXPECT_TRUE(same_classification(editor.function(), before));
}

TEST(TransferEditorTest, ANodeStaysBetweenItsNeighbours) {
  TransferEditor editor(*TransferFunction::create(
      "ramp", {{0, {1, 0, 0}, 0, 1}, {100, {1, 0, 0}, 0.5, 1}, {200, {1, 0, 0}, 0, 1}}));
  editor.move_node(0, 1, 1e6, 0.25);
  EXPECT_EQ(editor.components()[0].nodes[1].hu, 200 - TransferEditor::kLeastGap);
  EXPECT_EQ(editor.components()[0].nodes[1].opacity, 0.25);
  editor.move_node(0, 2, -50, 7);
  EXPECT_EQ(editor.components()[0].nodes[2].hu, 200);
  EXPECT_EQ(editor.components()[0].nodes[2].opacity, TransferEditor::kMostOpacity);
  editor.move_node(0, 0, NAN, NAN);
  EXPECT_EQ(editor.components()[0].nodes[0].hu, 0) << "NaN changes nothing";
}

TEST(TransferEditorTest, OpacityScalesTheWholeComponent) {
  TransferEditor editor(*TransferFunction::create(
      "ramp", {{0, {1, 0, 0}, 0.1, 1}, {100, {1, 0, 0}, 0.4, 1}, {200, {1, 0, 0}, 0, 1}}));
  editor.set_opacity(0, 0.8);
  EXPECT_NEAR(editor.components()[0].nodes[0].opacity, 0.2, kOpacity);
  EXPECT_NEAR(greatest_opacity(editor.components()[0]), 0.8, kOpacity);
  editor.set_opacity(0, 0);
  editor.set_opacity(0, 0.5);
  EXPECT_EQ(editor.components()[0].nodes[0].opacity, 0) << "the ends of a window stay closed";
  EXPECT_EQ(editor.components()[0].nodes[1].opacity, 0.5);
}

TEST(TransferEditorTest, CountsEveryValueOfASmallVolume) {
  VoxelGrid grid;
  grid.size = {10, 10, 10};
  std::vector<std::int16_t> values(grid.voxel_count());
  std::iota(values.begin(), values.end(), std::int16_t{0});
  const auto volume = *StoredVolume::create(grid, std::move(values), "ramp");
  const ValueCounts counts = count_values(volume, 0, 500, 5);
  for (const std::uint64_t bin : counts.bins) EXPECT_EQ(bin, 100U) << "values from 500 on are out";
}

}  // namespace
}  // namespace nav::render
