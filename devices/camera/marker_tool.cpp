// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/camera/marker_tool.hpp"

#include <charconv>
#include <map>

namespace nav::devices {
namespace {

constexpr int kMostSquares = 50;
constexpr double kLongestMm = 2000;

std::vector<std::string_view> parts_of(std::string_view text) {
  std::vector<std::string_view> parts;
  for (;;) {
    const auto colon = text.find(':');
    parts.push_back(text.substr(0, colon));
    if (colon == std::string_view::npos) return parts;
    text.remove_prefix(colon + 1);
  }
}

template <class Number>
bool read_number(std::string_view text, Number& number) {
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  return read.ec == std::errc() && read.ptr == end;
}

bool read_mm(std::string_view text, double& mm) {
  return read_number(text, mm) && mm > 0 && mm <= kLongestMm;
}

bool read_size(std::string_view text, MarkerTool& tool) {
  const auto x = text.find('x');
  if (x == std::string_view::npos) return false;
  return read_number(text.substr(0, x), tool.columns) &&
         read_number(text.substr(x + 1), tool.rows) && tool.columns >= 1 && tool.rows >= 1 &&
         tool.columns <= kMostSquares && tool.rows <= kMostSquares;
}

/// Numbers of cv::aruco::PREDEFINED_DICTIONARY_NAME.
const std::map<std::string, MarkerDictionary, std::less<>>& all_dictionaries() {
  static const std::map<std::string, MarkerDictionary, std::less<>> all{
      {"4x4_50", {0, 50}},          {"4x4_100", {1, 100}},
      {"4x4_250", {2, 250}},        {"4x4_1000", {3, 1000}},
      {"5x5_50", {4, 50}},          {"5x5_100", {5, 100}},
      {"5x5_250", {6, 250}},        {"5x5_1000", {7, 1000}},
      {"6x6_50", {8, 50}},          {"6x6_100", {9, 100}},
      {"6x6_250", {10, 250}},       {"6x6_1000", {11, 1000}},
      {"7x7_50", {12, 50}},         {"7x7_100", {13, 100}},
      {"7x7_250", {14, 250}},       {"7x7_1000", {15, 1000}},
      {"original", {16, 1024}},     {"apriltag_16h5", {17, 30}},
      {"apriltag_25h9", {18, 35}},  {"apriltag_36h10", {19, 2320}},
      {"apriltag_36h11", {20, 587}}};
  return all;
}

}  // namespace

int MarkerTool::marker_count() const {
  return kind == Kind::kCharuco ? columns * rows / 2 : columns * rows;
}

std::vector<PlacedMarker> markers_of(const MarkerTool& tool) {
  std::vector<PlacedMarker> markers;
  int id = tool.first_id;
  const bool board = tool.kind == MarkerTool::Kind::kCharuco;
  const double step = board ? tool.square_mm : tool.marker_mm + tool.gap_mm;
  const double side = tool.marker_mm;
  for (int row = 0; row < tool.rows; ++row) {
    for (int column = 0; column < tool.columns; ++column) {
      if (board && (row + column) % 2 == 0) continue;  // A black square.
      const Eigen::Vector2d middle((column - 0.5 * (tool.columns - 1)) * step,
                                   (0.5 * (tool.rows - 1) - row) * step);
      const double half = 0.5 * side;
      markers.push_back(
          {id++,
           {middle + Eigen::Vector2d(-half, half), middle + Eigen::Vector2d(half, half),
            middle + Eigen::Vector2d(half, -half), middle + Eigen::Vector2d(-half, -half)}});
    }
  }
  return markers;
}

std::vector<Eigen::Vector2d> chessboard_corners_of(const MarkerTool& tool) {
  std::vector<Eigen::Vector2d> corners;
  if (tool.kind != MarkerTool::Kind::kCharuco) return corners;
  for (int row = 1; row < tool.rows; ++row) {
    for (int column = 1; column < tool.columns; ++column) {
      corners.emplace_back((column - 0.5 * tool.columns) * tool.square_mm,
                           (0.5 * tool.rows - row) * tool.square_mm);
    }
  }
  return corners;
}

std::optional<MarkerTool> marker_tool(std::string_view text) {
  const auto parts = parts_of(text);
  MarkerTool tool;
  const auto first_at = [&](std::size_t at) {
    if (parts.size() == at) return true;
    return parts.size() == at + 1 && read_number(parts[at], tool.first_id) && tool.first_id >= 0;
  };
  if (parts[0] == "marker") {
    if (parts.size() != 3 || !read_number(parts[1], tool.first_id) || tool.first_id < 0 ||
        !read_mm(parts[2], tool.marker_mm)) {
      return std::nullopt;
    }
    return tool;
  }
  if (parts.size() < 4 || !read_size(parts[1], tool)) return std::nullopt;
  if (parts[0] == "grid") {
    tool.kind = MarkerTool::Kind::kGrid;
    const bool good =
        read_mm(parts[2], tool.marker_mm) && read_mm(parts[3], tool.gap_mm) && first_at(4);
    if (!good) return std::nullopt;
    return tool;
  }
  if (parts[0] != "charuco") return std::nullopt;
  tool.kind = MarkerTool::Kind::kCharuco;
  const bool good = read_mm(parts[2], tool.square_mm) && read_mm(parts[3], tool.marker_mm) &&
                    tool.marker_mm < tool.square_mm && tool.columns >= 2 && tool.rows >= 2 &&
                    tool.columns * tool.rows > 4 && first_at(4);
  if (!good) return std::nullopt;
  return tool;
}

const std::vector<std::string>& marker_dictionaries() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const auto& [name, dictionary] : all_dictionaries()) all.push_back(name);
    return all;
  }();
  return names;
}

std::optional<MarkerDictionary> marker_dictionary(std::string_view name) {
  const auto found = all_dictionaries().find(name);
  if (found == all_dictionaries().end()) return std::nullopt;
  return found->second;
}

Result<void> validate(const std::vector<MarkerTool>& tools, const std::string& dictionary) {
  const auto reject = [](const std::string& what) { return Error{ErrorCode::kUsage, what}; };
  const auto known = marker_dictionary(dictionary);
  if (!known) {
    std::string all;
    for (const auto& name : marker_dictionaries()) all.append(all.empty() ? "" : ", ").append(name);
    return reject("dictionary: expected one of " + all + ", found '" + dictionary + "'");
  }
  std::map<int, std::size_t> owners;
  for (std::size_t i = 0; i < tools.size(); ++i) {
    const int end = tools[i].first_id + tools[i].marker_count();
    if (end > known->markers) {
      return reject("bodies[" + std::to_string(i) + "].tool: expected markers below " +
                    std::to_string(known->markers) + " of the dictionary " + dictionary +
                    ", found " + std::to_string(end - 1));
    }
    for (int id = tools[i].first_id; id < end; ++id) {
      const auto [owner, is_new] = owners.emplace(id, i);
      if (is_new) continue;
      return reject("bodies[" + std::to_string(i) + "].tool: expected markers of its own, found " +
                    std::to_string(id) + " as in bodies[" + std::to_string(owner->second) + "]");
    }
  }
  return {};
}

}  // namespace nav::devices
