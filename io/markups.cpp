// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/markups.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <sstream>
#include <string_view>

#include "io/atomic_file.hpp"
#include "io/detail/text.hpp"
#include "io/json_member.hpp"
#include "nav/positions.hpp"

namespace nav::io {
namespace {

constexpr std::uint64_t kMostMarkupBytes = 64 << 20;

std::string lower(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

bool is_fcsv(const std::filesystem::path& path) {
  return lower(path.extension().string()) == ".fcsv";
}

/// Points so far.
struct Collected {
  Markups markups;
  std::size_t points = 0;
  std::vector<std::string> without_position;  ///< Names.

  /// Adds a point to the newest list. \p ras: the numbers are RAS.
  void add(const std::string& name, Eigen::Vector3d mm, bool ras) {
    ++points;
    if (ras) mm.head<2>() *= -1;
    markups.lists.back().push_back({name, mm});
  }
  void add_unplaced(const std::string& name) {
    ++points;
    without_position.push_back(name.empty() ? std::to_string(points) : name);
    markups.lists.back().push_back({name, Eigen::Vector3d::Zero(), false});
  }
};

Result<Markups> finish(Collected&& collected, const std::filesystem::path& path) {
  Markups& markups = collected.markups;
  if (!collected.without_position.empty()) {
    constexpr std::size_t kMostNames = 5;
    std::string names;
    for (std::size_t i = 0; i < collected.without_position.size() && i < kMostNames; ++i) {
      names += (i == 0 ? "" : ", ") + detail::excerpt(collected.without_position[i]);
    }
    if (collected.without_position.size() > kMostNames) names += ", …";
    markups.findings.push_back(
        {.subject = path.string(),
         .key = "positionStatus",
         .values = {std::to_string(collected.without_position.size()) + " of " +
                    std::to_string(collected.points) + " points without a position: " + names},
         .used = "the other points"});
  }
  if (collected.points == collected.without_position.size()) {
    return Error{ErrorCode::kMalformedData, path.string() + ": expected points, found none" +
                                                (collected.points > 0 ? " with a position" : "")};
  }
  return std::move(markups);
}

/// True for RAS, false for LPS; nothing for other names. Old tables have numbers.
std::optional<bool> is_ras(const std::string& system) {
  if (system == "RAS" || system == "0") return true;
  if (system == "LPS" || system == "1") return false;
  return std::nullopt;
}

// ---------------------------------------------------------------- tables (.fcsv)

/// Cells of a line; a cell in quotation marks may hold commas, and two marks in it are one.
std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      cells.back() += line[i++];
    } else if (line[i] == '"') {
      quoted = !quoted;
    } else if (line[i] == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += line[i];
    }
  }
  for (std::string& cell : cells) cell = std::string(detail::trim(cell));
  return cells;
}

/// Header of a table: lines "# key = value".
struct TableHeader {
  bool version = false;
  std::optional<std::string> system;
  std::vector<std::string> columns{"id", "x",   "y",   "z",    "ow",    "ox",   "oy",
                                   "oz", "vis", "sel", "lock", "label", "desc", "associatedNodeID"};
};

/// Column of a name, if the header has it.
std::optional<std::size_t> column(const TableHeader& header, std::string_view name) {
  const auto found = std::ranges::find(header.columns, name);
  if (found == header.columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header.columns.begin());
}

/// Takes a line of the header. An error is a clause.
std::optional<std::string> take_header(std::string_view line, TableHeader& header) {
  const std::size_t equals = line.find('=');
  if (equals == line.npos) return std::nullopt;  // A comment.
  const std::string key = lower(std::string(detail::trim(line.substr(1, equals - 1))));
  const std::string value(detail::trim(line.substr(equals + 1)));
  if (key == "markups fiducial file version") header.version = true;
  if (key == "columns") header.columns = cells_of(value);
  if (key != "coordinatesystem") return std::nullopt;
  if (!is_ras(value)) {
    return "CoordinateSystem: expected RAS, LPS, 0 (RAS) or 1 (LPS), found '" +
           detail::excerpt(value) + "'";
  }
  if (header.system && is_ras(*header.system) != is_ras(value)) {
    return "CoordinateSystem: expected one, found " + *header.system + " and " + value;
  }
  header.system = value;
  return std::nullopt;
}

/// Status of a point, which newer tables have behind the named columns: 0 undefined, 1 preview,
/// 2 defined, 3 missing. Without one the point is defined.
bool has_position(const TableHeader& header, const std::vector<std::string>& cells) {
  const std::size_t at =
      column(header, "positionStatus").value_or(std::max<std::size_t>(header.columns.size(), 1));
  return cells.size() <= at || cells[at].empty() || cells[at] == "2";
}

/// Takes a point. An error is a clause.
std::optional<std::string> take_point(std::string_view line, const TableHeader& header,
                                      Collected& into) {
  const auto cells = cells_of(line);
  const auto label = column(header, "label");
  const std::string name = label && *label < cells.size() ? cells[*label] : "";
  if (!has_position(header, cells)) {
    into.add_unplaced(name);
    return std::nullopt;
  }
  Eigen::Vector3d mm;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string letter(1, "xyz"[axis]);
    const auto at = column(header, letter);
    if (!at) return "columns: expected x, y and z, found none named " + letter;
    const std::string cell = *at < cells.size() ? cells[*at] : "nothing";
    const auto number = detail::parse_double(cell);
    if (!number || !std::isfinite(*number)) {
      return letter + ": expected a finite number, found '" + detail::excerpt(cell) + "'";
    }
    mm[axis] = *number;
  }
  if (!is_place(mm)) return "x, y and z: expected numbers within 1e7 mm, found others";
  into.add(name, mm, *is_ras(*header.system));
  return std::nullopt;
}

Result<Markups> read_table(const std::filesystem::path& path) {
  const auto text = read_file(path, kMostMarkupBytes);
  if (!text) return text.error();
  constexpr std::string_view kMark = "\xEF\xBB\xBF";  // Mark of UTF-8.
  std::istringstream lines(text->starts_with(kMark) ? text->substr(kMark.size()) : *text);
  TableHeader header;
  Collected collected;
  collected.markups.lists.emplace_back();
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::string_view trimmed = detail::trim(line);
    if (trimmed.empty()) continue;
    std::optional<std::string> fault;
    if (trimmed.front() == '#') {
      fault = take_header(trimmed, header);
    } else if (!header.version) {
      fault = "expected '# Markups fiducial file version = …' before the points, found none";
    } else if (!header.system) {
      fault = "expected '# CoordinateSystem = LPS' or RAS before the points, found none";
    } else {
      fault = take_point(trimmed, header, collected);
    }
    if (fault) {
      return Error{ErrorCode::kMalformedData,
                   path.string() + ":" + std::to_string(number) + ": " + *fault};
    }
  }
  return finish(std::move(collected), path);
}

// ---------------------------------------------------------------- JSON (.mrk.json)

/// Takes a control point. Members that say how it is shown are left alone.
void take_control_point(const Json& json, const std::string& where, bool ras,
                        std::optional<Error>& error, Collected& into) {
  constexpr std::array kStatus{"defined", "undefined", "preview", "missing"};
  JsonMember member(json, where, error);
  std::string name, status = "defined";
  std::vector<double> position;
  member.text("label", name);
  member.text("positionStatus", status);
  if (error) return;
  if (std::ranges::find(kStatus, status) == kStatus.end()) {
    return member.fail("positionStatus", "defined, undefined, preview or missing", status);
  }
  if (status != kStatus[0]) return into.add_unplaced(name);
  member.numbers("position", 3, position);
  if (error) return;
  if (position.empty()) return member.fail("position", "3 numbers", nullptr);
  const Eigen::Vector3d mm(position[0], position[1], position[2]);
  if (!mm.allFinite() || !is_place(mm)) {
    return member.fail("position", "numbers within 1e7 mm", json.at("position"));
  }
  into.add(name, mm, ras);
}

void take_markup(const Json& json, const std::string& where, std::optional<Error>& error,
                 Collected& into) {
  JsonMember member(json, where, error);
  std::string system;
  member.text("coordinateSystem", system);
  if (error) return;
  const auto ras = is_ras(system);
  if (!ras || system.size() == 1) {
    const Json* found = member.any("coordinateSystem");
    return member.fail("coordinateSystem", "LPS or RAS", found == nullptr ? Json() : *found);
  }
  const Json* units = member.any("coordinateUnits");
  if (units != nullptr && *units != "mm") return member.fail("coordinateUnits", "mm", *units);
  into.markups.lists.emplace_back();
  member.list("controlPoints", [&](const Json& point, const std::string& at) {
    take_control_point(point, at, *ras, error, into);
  });
}

Result<Markups> read_markup_json(const std::filesystem::path& path) {
  const auto json = read_json(path, kMostMarkupBytes);
  if (!json) return json.error();
  std::optional<Error> error;
  JsonMember root(*json, path.string(), error);
  std::string schema;
  root.text("@schema", schema);
  if (!error && schema.find("markups-schema-v1.") == schema.npos) {
    const Json* found = root.any("@schema");
    root.fail("@schema", "a schema of Markups, version 1 (markups-schema-v1.…)",
              found == nullptr ? Json() : *found);
  }
  Collected collected;
  if (!error && root.any("markups") == nullptr) root.fail("markups", "a list", nullptr);
  root.list("markups", [&](const Json& markup, const std::string& where) {
    take_markup(markup, where, error, collected);
  });
  if (error) return *error;
  return finish(std::move(collected), path);
}

}  // namespace

bool is_markups_file(const std::filesystem::path& path) {
  return is_fcsv(path) || lower(path.filename().string()).ends_with(".mrk.json");
}

Result<Markups> read_markups(const std::filesystem::path& path) {
  return is_fcsv(path) ? read_table(path) : read_markup_json(path);
}

}  // namespace nav::io
