// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/surface_file.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "io/atomic_file.hpp"
#include "io/detail/surface_cursor.hpp"
#include "io/detail/text.hpp"

namespace nav::io {
namespace {

constexpr std::uint64_t kMaxTextBytes = 256 << 20;
constexpr std::uint64_t kMaxSurfaceBytes = 1 << 30;

/// Titles and comments of each file format; views into the text.
constexpr std::size_t kMostHead = 64 << 10;
std::string_view stl_title(std::string_view head) {
  constexpr std::size_t kTitle = 80;  // In text files it ends with the line.
  const bool words = head.starts_with("solid");
  return head.substr(0, std::min(kTitle, words ? head.find('\n') : kTitle));
}
std::string_view ply_header(std::string_view head) {
  return head.substr(0, head.find("\nend_header"));
}
std::string_view vtk_title(std::string_view head) {
  head.remove_prefix(std::min(head.find('\n'), head.size() - 1) + 1);
  return head.substr(0, head.find('\n'));
}

/// Interprets "SPACE=RAS", written by 3D Slicer and Mimics: x and y point the other way. Without it
/// the space is LPS, as in 3D Slicer. The end of a longer word (COLORSPACE=) does not count.
Result<void> turn_to_lps(std::string_view comments, TriangleMesh& mesh) {
  constexpr std::string_view kSpace = "SPACE=";
  const auto in_word = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
  };
  std::optional<std::string_view> said;
  for (auto at = comments.find(kSpace); at != comments.npos; at = comments.find(kSpace, at + 1)) {
    if (at > 0 && in_word(comments[at - 1])) continue;
    const std::string_view rest = comments.substr(at + kSpace.size());
    const auto end = std::ranges::find_if_not(rest, in_word);
    const std::string_view value(rest.begin(), end);
    if (value != "LPS" && value != "RAS") {
      return Error{ErrorCode::kUnsupportedData,
                   mesh.name + ": expected SPACE=LPS or SPACE=RAS, found '" +
                       detail::excerpt(rest.substr(0, rest.find_first_of(" \t\r\n;"))) + "'"};
    }
    if (said && *said != value) {
      return Error{ErrorCode::kUnsupportedData,
                   mesh.name + ": expected one SPACE, found 'LPS' and 'RAS'"};
    }
    said = value;
  }
  if (said != "RAS") return {};
  for (Eigen::Vector3d& point : mesh.points_mm) point.head<2>() *= -1;
  return {};
}

}  // namespace

Result<TriangleMesh> read_surface(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    return Error{ErrorCode::kNotFound, path.string() + ": expected a surface, found no file"};
  }
  const std::string ending = path.extension().string();
  const bool stl = detail::equals_ignoring_case(ending, ".stl");
  const bool ply = detail::equals_ignoring_case(ending, ".ply");
  if (!stl && !ply && !detail::equals_ignoring_case(ending, ".vtk")) {
    return Error{
        ErrorCode::kUnsupportedData,
        path.string() + ": expected a surface as .vtk, .stl or .ply, found '" + ending + "'"};
  }
  const auto content = read_file(path, kMaxSurfaceBytes);
  if (!content) return content.error();
  auto mesh = stl   ? detail::read_stl(path, *content)
              : ply ? detail::read_ply(path, *content)
                    : detail::read_legacy_vtk(path, *content);
  if (!mesh) return mesh;
  const std::string_view head = std::string_view(*content).substr(0, kMostHead);
  const std::string_view comments = stl   ? stl_title(head)
                                    : ply ? ply_header(head)
                                          : vtk_title(head);
  if (auto ok = turn_to_lps(comments, *mesh); !ok) return ok.error();
  return mesh;
}

namespace {

/// True for names of three columns.
bool is_heading(std::string_view line) {
  const auto words = detail::split_words(line);
  return words.size() == 3 && std::none_of(words.begin(), words.end(), [](std::string_view word) {
           return detail::parse_double(word).has_value();
         });
}

/// Replaces what separates the cells of a table by spaces. A comma is the decimal point of a line
/// that semicolons separate, and of cells in quotation marks.
void separate_cells(std::string& line) {
  const bool semicolons = line.find(';') != std::string::npos;
  bool quoted = false;
  for (char& c : line) {
    if (c == '"') quoted = !quoted;
    if (c == ',') c = semicolons || quoted ? '.' : ' ';
    if (c == ';' || c == '"') c = ' ';
  }
}

}  // namespace

Result<std::vector<std::vector<Eigen::Vector3d>>> read_point_groups(
    const std::filesystem::path& path) {
  const auto text = read_file(path, kMaxTextBytes);
  if (!text) return text.error();
  std::vector<std::vector<Eigen::Vector3d>> groups;
  bool within = false;
  int number = 0;
  std::istringstream stream(*text);
  bool first = true;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (number == 1 && line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);  // Mark of UTF-8.
    separate_cells(line);
    const auto trimmed = detail::trim(line);
    if (!trimmed.empty() && trimmed.front() == '#') continue;
    if (trimmed.empty()) {
      within = false;
      continue;
    }
    const bool heads = std::exchange(first, false) && is_heading(trimmed);
    if (heads) continue;
    const auto numbers = detail::parse_doubles(trimmed);
    const bool finite = numbers && std::all_of(numbers->begin(), numbers->end(),
                                               [](double x) { return std::isfinite(x); });
    if (!finite || numbers->size() != 3) {
      return Error{ErrorCode::kMalformedData, path.string() + ":" + std::to_string(number) +
                                                  ": expected three finite numbers, found '" +
                                                  detail::excerpt(trimmed) + "'"};
    }
    if (!within) groups.emplace_back();
    within = true;
    groups.back().emplace_back((*numbers)[0], (*numbers)[1], (*numbers)[2]);
  }
  if (groups.empty()) return detail::malformed_surface(path, "points", "none");
  return groups;
}

}  // namespace nav::io
