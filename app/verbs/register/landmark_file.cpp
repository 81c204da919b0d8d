// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/register/landmark_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <string_view>

#include "io/atomic_file.hpp"
#include "io/markups.hpp"

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

/// A cell as a number; a comma is the decimal point of spreadsheets of some languages. Absent for
/// what is no finite number.
std::optional<double> number_in(std::string cell) {
  const bool decimal_comma =
      std::ranges::count(cell, ',') == 1 && cell.find('.') == std::string::npos;
  if (decimal_comma) cell[cell.find(',')] = '.';
  double value = 0;
  const auto end = cell.data() + cell.size();
  const auto parsed = std::from_chars(cell.data(), end, value);
  const bool good = parsed.ec == std::errc() && parsed.ptr == end && std::isfinite(value);
  return good ? std::optional(value) : std::nullopt;
}

/// True for a first line that is not the names of the columns but a pair already.
bool is_pair(const std::vector<std::string>& cells) {
  const std::size_t count = cells.size();
  const bool fits = count == kRequired.size() || count == kRequired.size() + 1 ||
                    count == kRequired.size() + kAxes.size();
  return fits && std::ranges::all_of(cells.begin() + 1, cells.end(), [](const std::string& cell) {
           return number_in(cell).has_value();
         });
}

/// The separator of the cells of a table, by one of its lines.
char separator_of(std::string_view line) {
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == ';' && !quoted) return ';';
  }
  return ',';
}

/// A cell in a message.
std::string shown(const std::string& cell) {
  constexpr std::size_t kMost = 40;
  return cell.size() > kMost ? cell.substr(0, kMost) + "…" : cell;
}

/// The first column that has another name than expected; absent if there is none.
std::optional<std::string> wrong_column(const std::vector<std::string>& cells,
                                        const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < std::max(cells.size(), names.size()); ++i) {
    const std::string found = i < cells.size() ? cells[i] : "nothing";
    const std::string expected = i < names.size() ? names[i] : "absent";
    if (found == expected) continue;
    return "expected column " + std::to_string(i + 1) + " to be " + expected + ", found " +
           shown(found);
  }
  return std::nullopt;
}

using MarkupList = std::vector<io::MarkupPoint>;

/// All points of a Markups file in one list; findings go to the diagnostics.
Result<MarkupList> all_markups(const std::filesystem::path& path, Diagnostics& diagnostics) {
  auto markups = io::read_markups(path);
  if (!markups) return markups.error();
  for (const Finding& finding : markups->findings) diagnostics.report("landmarks", finding);
  MarkupList all;
  for (const MarkupList& list : markups->lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

std::vector<std::string> names_of(const MarkupList& points) {
  std::vector<std::string> names;
  for (const io::MarkupPoint& point : points) names.push_back(point.name);
  return names;
}

/// The first name that one list has and another has not; absent if there is none.
std::optional<std::string> unpaired_label(const std::vector<std::string>& names,
                                          const std::vector<std::string>& others) {
  const auto found = std::ranges::find_if(names, [&](const std::string& name) {
    return name.empty() || std::ranges::count(others, name) != 1;
  });
  return found == names.end() ? std::nullopt : std::optional(*found);
}

/// The points of \p ct in the order of their partners in \p reference.
Result<MarkupList> partners(const MarkupList& reference, const MarkupList& ct,
                            const std::filesystem::path& reference_file,
                            const std::filesystem::path& ct_file, Diagnostics& diagnostics) {
  const auto reject = [&](const std::string& expected, const std::string& found) {
    return Error{ErrorCode::kMalformedData,
                 ct_file.string() + ": expected " + expected + ", found " + found};
  };
  if (reference.size() != ct.size()) {
    return reject(std::to_string(reference.size()) + " points, as in " + reference_file.string(),
                  std::to_string(ct.size()));
  }
  const auto names = names_of(reference);
  const auto others = names_of(ct);
  const auto finding = [&](const std::string& value, const std::string& used) {
    diagnostics.report("landmarks", {.subject = ct_file.string(),
                                     .key = "pairs of landmarks",
                                     .values = {value},
                                     .used = used,
                                     .severity = Severity::kInfo});
  };
  const auto lacks = unpaired_label(names, others);
  if (!lacks && !unpaired_label(others, names)) {
    if (names != others) {
      finding("another order than in " + reference_file.string(), "points of the same label");
    }
    MarkupList sorted;
    for (const std::string& name : names) {
      sorted.push_back(*std::ranges::find(ct, name, &io::MarkupPoint::name));
    }
    return sorted;
  }
  const bool shared = std::ranges::any_of(names, [&](const std::string& name) {
    return !name.empty() && std::ranges::count(others, name) > 0;
  });
  if (shared) {
    const auto unpaired = lacks ? lacks : unpaired_label(others, names);
    return reject("the labels of " + reference_file.string() + ", each once, or none of them",
                  "some of them, not '" + shown(unpaired.value_or("")) + "'");
  }
  finding("no label of " + reference_file.string(), "points of equal positions in the lists");
  return ct;
}

}  // namespace

Result<LandmarkList> read_landmark_markups(const std::filesystem::path& reference,
                                           const std::filesystem::path& ct,
                                           Diagnostics& diagnostics) {
  const auto touched = all_markups(reference, diagnostics);
  if (!touched) return touched.error();
  const auto seen = all_markups(ct, diagnostics);
  if (!seen) return seen.error();
  const auto sorted = partners(*touched, *seen, reference, ct, diagnostics);
  if (!sorted) return sorted.error();
  LandmarkList list;
  for (std::size_t i = 0; i < touched->size(); ++i) {
    const io::MarkupPoint& from = (*touched)[i];
    const io::MarkupPoint& to = (*sorted)[i];
    if (!from.placed || !to.placed) continue;
    const std::string name = !from.name.empty() ? from.name : "point " + std::to_string(i + 1);
    list.pairs.push_back({name, {from.ras_mm()}, {to.lps_mm}, 1.0});
  }
  if (!list.pairs.empty()) return list;
  return Error{ErrorCode::kMalformedData, ct.string() + ": expected pairs with " +
                                              reference.string() +
                                              " of which both points have a position, found none"};
}

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
    if (columns == 0) separator = separator_of(line);
    const auto cells = split(line, separator);
    if (cells.empty() || (cells.size() == 1 && cells[0].empty()) || cells[0].starts_with('#')) {
      continue;
    }
    if (columns == 0) {
      names = expected_columns(cells);
      columns = cells.size();
      if (!is_pair(cells)) {
        if (const auto wrong = wrong_column(cells, names)) return reject(*wrong);
        continue;
      }
    }
    if (cells.size() != columns) {
      return reject("expected " + std::to_string(columns) + " values, found " +
                    std::to_string(cells.size()));
    }
    std::array<double, kAllNumbers> values{};
    for (std::size_t i = 1; i < columns; ++i) {
      const auto value = number_in(cells[i]);
      if (!value) {
        return reject(names[i] + ": expected a finite number, found '" + shown(cells[i]) + "'");
      }
      values[i - 1] = *value;
    }
    add(cells[0], values, columns, list);
  }
  if (list.pairs.empty()) {
    return Error{ErrorCode::kMalformedData,
                 path.string() + ": expected landmark pairs, found none"};
  }
  return list;
}

Result<void> check_unit(const std::vector<Eigen::Vector3d>& points, const std::string& what) {
  constexpr std::size_t kEnough = 3;
  constexpr double kLeastMm = 1;
  constexpr double kMostMm = 2000;
  if (points.size() < kEnough) return {};
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) centre += point / static_cast<double>(points.size());
  double farthest_mm = 0;
  for (const Eigen::Vector3d& point : points) {
    farthest_mm = std::max(farthest_mm, (point - centre).norm());
  }
  // Points in one place have no unit.
  if (farthest_mm == 0 || (farthest_mm >= kLeastMm && farthest_mm <= kMostMm)) return {};
  std::ostringstream text;
  text << what << ": expected points in millimetres, " << kLeastMm << " to " << kMostMm
       << " mm about their centre, found them within " << farthest_mm << " mm (are they in "
       << (farthest_mm < kLeastMm ? "metres" : "micrometres") << "?)";
  return Error{ErrorCode::kMalformedData, text.str()};
}

}  // namespace nav::app
