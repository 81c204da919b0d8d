// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/register/landmark_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "io/atomic_file.hpp"

namespace nav::app {
namespace {

constexpr std::array kRequired = {"name",    "reference_x_mm", "reference_y_mm", "reference_z_mm",
                                  "ct_x_mm", "ct_y_mm",        "ct_z_mm"};
constexpr std::array kAxes = {"reference_sigma_x_mm", "reference_sigma_y_mm",
                              "reference_sigma_z_mm", "ct_sigma_x_mm",
                              "ct_sigma_y_mm",        "ct_sigma_z_mm"};
constexpr std::size_t kAllNumbers = kRequired.size() - 1 + kAxes.size();

/// Column names that a file with this number of cells should have.
std::vector<std::string> expected_columns(const std::vector<std::string>& cells) {
  std::vector<std::string> columns(kRequired.begin(), kRequired.end());
  if (cells.size() <= kRequired.size()) return columns;
  if (cells.size() == kRequired.size() + 1) {
    columns.emplace_back("sigma_mm");
  } else {
    columns.insert(columns.end(), kAxes.begin(), kAxes.end());
  }
  return columns;
}

/// Adds a pair with the numbers of one line to the list.
void add(const std::string& name, const std::array<double, kAllNumbers>& v, std::size_t columns,
         LandmarkList& list) {
  registration::LandmarkPair pair{name, {{v[0], v[1], v[2]}}, {{v[3], v[4], v[5]}}, 1.0};
  list.sigmas_given = columns > kRequired.size();
  if (columns == kRequired.size() + 1) pair.sigma_mm = v[6];
  if (columns > kRequired.size() + 1) {
    const Eigen::Vector3d reference = Eigen::Vector3d(v[6], v[7], v[8]).cwiseAbs2();
    const Eigen::Vector3d ct = Eigen::Vector3d(v[9], v[10], v[11]).cwiseAbs2();
    pair.sigma_mm = std::sqrt((reference + ct).sum() / 3);
    list.shaped.push_back({.name = name,
                           .reference = pair.reference,
                           .ct = pair.ct,
                           .reference_covariance_mm2 = reference.asDiagonal(),
                           .ct_covariance_mm2 = ct.asDiagonal()});
  }
  list.pairs.push_back(std::move(pair));
}

std::vector<std::string> split(std::string line, char separator) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
  if (line.empty()) return {};
  std::vector<std::string> cells;
  std::string cell;
  const auto end_cell = [&] {
    const auto first = cell.find_first_not_of(" \t");
    const auto last = cell.find_last_not_of(" \t");
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
    cell.clear();
  };
  // A cell in quotation marks may hold the separator; two marks in it are one (RFC 4180).
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      cell += c;
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == separator && !quoted) {
      end_cell();
    } else {
      cell += c;
    }
  }
  if (!cell.empty() || line.back() != separator) end_cell();
  return cells;
}

}  // namespace

Result<LandmarkList> read_landmarks(const std::filesystem::path& path) {
  constexpr std::uint64_t kMaxBytes = 16 << 20;
  const auto text = io::read_file(path, kMaxBytes);
  if (!text) return text.error();
  LandmarkList list;
  // Spreadsheets begin a table with a byte order mark, and some separate its cells by semicolons.
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  std::istringstream stream(text->starts_with(kMark) ? text->substr(kMark.size()) : *text);
  char separator = ',';
  std::vector<std::string> names;
  std::size_t columns = 0;
  int number = 0;
  const auto reject = [&](const std::string& what) {
    return Error{ErrorCode::kMalformedData,
                 path.string() + ":" + std::to_string(number) + ": " + what};
  };
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (columns == 0 && line.find(';') != std::string::npos) separator = ';';
    const auto cells = split(line, separator);
    if (cells.empty() || (cells.size() == 1 && cells[0].empty()) || cells[0].starts_with('#')) {
      continue;
    }
    if (columns == 0) {
      names = expected_columns(cells);
      for (std::size_t i = 0; i < std::max(cells.size(), names.size()); ++i) {
        const std::string found = i < cells.size() ? cells[i] : "nothing";
        const std::string expected = i < names.size() ? names[i] : "absent";
        if (found != expected) {
          return reject("expected column " + std::to_string(i + 1) + " to be " + expected +
                        ", found " + found);
        }
      }
      columns = cells.size();
      continue;
    }
    if (cells.size() != columns) {
      return reject("expected " + std::to_string(columns) + " values, found " +
                    std::to_string(cells.size()));
    }
    std::array<double, kAllNumbers> values{};
    for (std::size_t i = 1; i < columns; ++i) {
      const std::string& cell = cells[i];
      const auto end = cell.data() + cell.size();
      const auto parsed = std::from_chars(cell.data(), end, values[i - 1]);
      if (parsed.ec != std::errc() || parsed.ptr != end || !std::isfinite(values[i - 1])) {
        return reject(names[i] + ": expected a finite number, found '" + cell + "'");
      }
    }
    add(cells[0], values, columns, list);
  }
  if (list.pairs.empty()) {
    return Error{ErrorCode::kMalformedData,
                 path.string() + ": expected landmark pairs, found none"};
  }
  return list;
}

}  // namespace nav::app
