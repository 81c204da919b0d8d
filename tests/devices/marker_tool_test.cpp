// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/camera/marker_tool.hpp"

#include <gtest/gtest.h>
#include <opencv2/aruco/charuco.hpp>

#include "tests/support/matchers.hpp"

namespace nav::devices {
namespace {

TEST(MarkerToolTest, ReadsItsThreeForms) {
  const auto marker = marker_tool("marker:7:40");
  ASSERT_TRUE(marker);
  EXPECT_EQ(marker->first_id, 7);
  EXPECT_EQ(marker->marker_mm, 40);
  const auto grid = marker_tool("grid:4x3:20.5:5:12");
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->marker_count(), 12);
  EXPECT_EQ(grid->first_id, 12);
  const auto board = marker_tool("charuco:5x7:20:15");
  ASSERT_TRUE(board);
  EXPECT_EQ(board->marker_count(), 17);
  EXPECT_EQ(chessboard_corners_of(*board).size(), 24U);
  for (const char* wrong :
       {"", "marker", "marker:7", "marker:-1:40", "marker:7:0", "marker:7:40:1", "grid:4:20:5",
        "grid:0x3:20:5", "grid:51x3:20:5", "charuco:5x7:15:20", "charuco:1x7:20:15",
        "charuco:5x7:20:15:x", "board:5x7:20:15", "marker:7:nan", "marker:7:1e9"}) {
    EXPECT_FALSE(marker_tool(wrong)) << wrong;
  }
}

/// A board that OpenCV printed is the board that is looked for: x to the right, y up, origin in the
/// middle.
TEST(MarkerToolTest, LaysBoardsOutAsOpenCv46DrawsThem) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(0);
  for (const auto& [columns, rows] : {std::pair{5, 7}, {4, 6}, {3, 3}}) {
    const auto tool =
        *marker_tool("charuco:" + std::to_string(columns) + "x" + std::to_string(rows) + ":20:15");
    const auto board = cv::aruco::CharucoBoard::create(columns, rows, 20, 15, dictionary);
    const auto ours = [&, half_x = 10.0 * columns, half_y = 10.0 * rows](const cv::Point3f& p) {
      return Eigen::Vector2d(p.x - half_x, half_y - p.y);
    };
    const auto markers = markers_of(tool);
    ASSERT_EQ(markers.size(), board->ids.size());
    for (std::size_t i = 0; i < markers.size(); ++i) {
      EXPECT_EQ(markers[i].id, board->ids[i]);
      for (std::size_t c = 0; c < 4; ++c) {
        EXPECT_LT((markers[i].corners_mm[c] - ours(board->objPoints[i][c])).norm(), 1e-4);
      }
    }
    const auto corners = chessboard_corners_of(tool);
    ASSERT_EQ(corners.size(), board->chessboardCorners.size());
    for (std::size_t i = 0; i < corners.size(); ++i) {
      EXPECT_LT((corners[i] - ours(board->chessboardCorners[i])).norm(), 1e-4);
    }
  }
}

TEST(MarkerToolTest, TheDictionariesAreThoseOfOpenCv) {
  for (const std::string& name : marker_dictionaries()) {
    const auto ours = marker_dictionary(name);
    ASSERT_TRUE(ours) << name;
    EXPECT_EQ(cv::aruco::getPredefinedDictionary(ours->number)->bytesList.rows, ours->markers)
        << name;
  }
  EXPECT_FALSE(marker_dictionary("9x9_50"));
}

TEST(MarkerToolTest, SharedAndMissingMarkersAreNamed) {
  const auto tools = [](std::initializer_list<const char*> texts) {
    std::vector<MarkerTool> all;
    for (const char* text : texts) all.push_back(*marker_tool(text));
    return all;
  };
  EXPECT_TRUE(test::has_value(validate(tools({"marker:7:40", "grid:2x2:20:5:8"}), "4x4_50")));
  EXPECT_TRUE(test::rejects(validate(tools({"marker:7:40", "grid:3x3:20:5"}), "4x4_50"),
                            ErrorCode::kUsage, {"bodies[1].tool", "found 7", "bodies[0]"}));
  EXPECT_TRUE(test::rejects(validate(tools({"marker:50:40"}), "4x4_50"), ErrorCode::kUsage,
                            {"bodies[0].tool", "below 50", "4x4_50", "found 50"}));
  EXPECT_TRUE(test::rejects(validate(tools({"marker:1:40"}), "4x4"), ErrorCode::kUsage,
                            {"dictionary", "apriltag_36h11", "'4x4'"}));
}

}  // namespace
}  // namespace nav::devices
