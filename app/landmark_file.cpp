// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/landmark_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "io/atomic_file.hpp"

namespace nav::app {
namespace {

constexpr const char* kColumns[] = {"name",    "reference_x_mm", "reference_y_mm", "reference_z_mm",
                                    "ct_x_mm", "ct_y_mm",        "ct_z_mm",        "sigma_mm"};
constexpr std::size_t kRequired = 7;

std::vector<std::string> split(std::string line) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) {
    const auto first = cell.find_first_not_of(" \t");
    const auto last = cell.find_last_not_of(" \t");
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  return cells;
}

}  // namespace

Result<std::vector<registration::LandmarkPair>> read_landmarks(const std::filesystem::path& path) {
  constexpr std::uint64_t kMaxBytes = 16 << 20;
  const auto text = io::read_file(path, kMaxBytes);
  if (!text) return text.error();
  std::vector<registration::LandmarkPair> pairs;
  std::istringstream stream(*text);
  std::size_t columns = 0;
  int number = 0;
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kMalformedData,
                 path.string() + ":" + std::to_string(number) + ": " + what};
  };
  for (std::string line; std::getline(stream, line);) {
    ++number;
    const auto cells = split(line);
    if (cells.empty() || (cells.size() == 1 && cells[0].empty()) || cells[0].starts_with('#')) {
      continue;
    }
    if (columns == 0) {
      for (std::size_t i = 0; i < std::max(cells.size(), kRequired); ++i) {
        const std::string found = i < cells.size() ? cells[i] : "nothing";
        if (i >= std::size(kColumns) || found != kColumns[i]) {
          return refuse("expected column " + std::to_string(i + 1) + " to be " +
                        (i < std::size(kColumns) ? kColumns[i] : "absent") + ", found " + found);
        }
      }
      columns = cells.size();
      continue;
    }
    if (cells.size() != columns) {
      return refuse("expected " + std::to_string(columns) + " values, found " +
                    std::to_string(cells.size()));
    }
    std::array<double, 7> values{0, 0, 0, 0, 0, 0, 1};
    for (std::size_t i = 1; i < columns; ++i) {
      const std::string& cell = cells[i];
      const auto end = cell.data() + cell.size();
      const auto parsed = std::from_chars(cell.data(), end, values[i - 1]);
      if (parsed.ec != std::errc() || parsed.ptr != end || !std::isfinite(values[i - 1])) {
        return refuse(std::string(kColumns[i]) + ": expected a finite number, found '" + cell +
                      "'");
      }
    }
    pairs.push_back({cells[0],
                     {{values[0], values[1], values[2]}},
                     {{values[3], values[4], values[5]}},
                     values[6]});
  }
  if (pairs.empty()) {
    return Error{ErrorCode::kMalformedData,
                 path.string() + ": expected landmark pairs, found none"};
  }
  return pairs;
}

}  // namespace nav::app
