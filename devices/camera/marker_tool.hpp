// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nav/result.hpp"

namespace nav::devices {

/// A flat pattern of printed markers that a camera tracks. Its frame: origin in the middle of the
/// pattern, x to the right and y up as the pattern is printed, z out of it.
struct MarkerTool {
  enum class Kind {
    kMarker,   ///< One ArUco marker.
    kGrid,     ///< Markers in columns and rows.
    kCharuco,  ///< A chessboard with markers in its white squares.
  };
  Kind kind = Kind::kMarker;
  int columns = 1;  ///< Markers of a grid, squares of a ChArUco board.
  int rows = 1;
  double square_mm = 0;  ///< ChArUco: side of a square.
  double marker_mm = 0;  ///< Side of a marker: of its black square.
  double gap_mm = 0;     ///< Grid: between two markers.
  int first_id = 0;      ///< Number of the (first) marker in its dictionary.

  /// Markers of the pattern, numbered one after the other from first_id.
  [[nodiscard]] int marker_count() const;
};

/// A marker in its pattern.
struct PlacedMarker {
  int id = 0;
  /// Corners of its black square in the frame of the tool, mm: as printed, from the top left corner
  /// to the right, and on around.
  std::array<Eigen::Vector2d, 4> corners_mm;
};
/// The markers of a tool, as OpenCV 4.6 draws its boards: from left to right and from top to
/// bottom.
std::vector<PlacedMarker> markers_of(const MarkerTool& tool);
/// Inner corners of a chessboard, mm; none for other tools.
std::vector<Eigen::Vector2d> chessboard_corners_of(const MarkerTool& tool);

/// Reads "marker:7:40" (number, side in mm), "grid:4x3:40:10" (columns x rows, side and gap in mm)
/// and "charuco:5x7:20:15" (squares, side of a square and of a marker in mm); the last two may end
/// with ":FIRST", the number of the first marker, 0 by default. Absent: anything else.
std::optional<MarkerTool> marker_tool(std::string_view text);
/// Forms that marker_tool() reads, for messages.
inline constexpr const char* kMarkerToolForms =
    "marker:NUMBER:SIDE_MM, grid:COLUMNSxROWS:SIDE_MM:GAP_MM[:FIRST] or "
    "charuco:COLUMNSxROWS:SQUARE_MM:MARKER_MM[:FIRST]";

/// Names of the dictionaries of OpenCV: "4x4_50" … "7x7_1000", "original", "apriltag_36h11", …
const std::vector<std::string>& marker_dictionaries();
/// Number of a dictionary in OpenCV, and how many markers it has. Absent: there is none of the
/// name.
struct MarkerDictionary {
  int number = 0;
  int markers = 0;
};
std::optional<MarkerDictionary> marker_dictionary(std::string_view name);

/// Rejects tools that share a marker, and markers that the dictionary does not have.
Result<void> validate(const std::vector<MarkerTool>& tools, const std::string& dictionary);

}  // namespace nav::devices
