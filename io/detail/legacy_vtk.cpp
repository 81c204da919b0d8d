// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "io/detail/surface_cursor.hpp"
#include "io/detail/text.hpp"

namespace nav::io::detail {

namespace {

std::optional<NumberKind> vtk_kind(std::string_view name) {
  struct Known {
    std::string_view name;
    NumberKind kind;
  };
  constexpr std::array kKnown = {
      Known{"float", {4, true, true}},         Known{"double", {8, true, true}},
      Known{"char", {1, false, true}},         Known{"unsigned_char", {1, false, false}},
      Known{"short", {2, false, true}},        Known{"unsigned_short", {2, false, false}},
      Known{"int", {4, false, true}},          Known{"unsigned_int", {4, false, false}},
      Known{"vtktypeint64", {8, false, true}}, Known{"vtkidtype", {4, false, true}}};
  for (const Known& known : kKnown) {
    if (equals_ignoring_case(known.name, name)) return known.kind;
  }
  return {};
}

/// Reader of legacy VTK files. Format: "VTK File Formats" of Kitware, legacy formats; offsets and
/// connectivity since 5.1.
class LegacyVtk {
 public:
  LegacyVtk(const std::filesystem::path& path, std::string_view content)
      : path_(path), cursor_(content), mesh_(path) {}

  Result<TriangleMesh> read() {
    const auto magic = cursor_.line();
    constexpr std::string_view kMagic = "# vtk DataFile Version ";
    if (!magic || !magic->starts_with(kMagic)) return reject("'# vtk DataFile Version'", magic);
    modern_ = parse_double(magic->substr(kMagic.size())).value_or(0) >= 5;
    cursor_.line();  // Skips the title.
    const auto coding = cursor_.filled_line();
    if (!coding) return reject("ASCII or BINARY", coding);
    const bool binary = equals_ignoring_case(trim(*coding), "BINARY");
    if (!binary && !equals_ignoring_case(trim(*coding), "ASCII")) {
      return reject("ASCII or BINARY", coding);
    }
    coding_ = binary ? NumberCoding::kBigEndian : NumberCoding::kText;
    const auto dataset = cursor_.filled_line();
    const auto words = split_words(dataset.value_or(""));
    if (words.size() != 2 || !is(words[0], "DATASET") || !is(words[1], "POLYDATA")) {
      return reject("DATASET POLYDATA", dataset);
    }
    while (const auto line = cursor_.filled_line()) {
      const auto section = split_words(*line);
      // The remaining sections are attributes such as colours.
      if (is(section[0], "POINT_DATA") || is(section[0], "CELL_DATA")) break;
      if (const auto ok = take(section, *line); !ok) return ok.error();
    }
    return std::move(mesh_).take();
  }

 private:
  static bool is(std::string_view word, std::string_view name) {
    return equals_ignoring_case(word, name);
  }
  Error reject(const std::string& expected, const std::optional<std::string_view>& found) const {
    return unexpected_line(path_, expected, found);
  }

  Result<void> take(const std::vector<std::string_view>& words, std::string_view line) {
    const auto count = words.size() > 1 ? parse_int(words[1]) : std::nullopt;
    if (is(words[0], "METADATA")) {
      for (auto next = cursor_.line(); next && !trim(*next).empty();) next = cursor_.line();
      return {};
    }
    if (is(words[0], "FIELD") && words.size() == 3) return skip_field(parse_int(words[2]), line);
    if (words.size() == 3 && count && *count >= 0) {
      if (is(words[0], "POINTS")) return take_points(*count, words[2], line);
      const auto size = parse_int(words[2]);
      for (const char* kind : {"VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS"}) {
        if (is(words[0], kind) && size && *size >= 0) return take_cells(kind, *count, *size);
      }
    }
    return reject("POINTS, POLYGONS or another section with its sizes", line);
  }

  /// Reads that many numbers, or returns an error with their meaning.
  Result<std::vector<double>> numbers(std::uint64_t count, const NumberKind& kind,
                                      const std::string& what) {
    const auto fail = [&](std::size_t found) {
      return malformed_surface(path_, std::to_string(count) + " numbers of " + what,
                               std::to_string(found));
    };
    if (!cursor_.may_hold(count, kind, coding_)) return fail(0);
    std::vector<double> out;
    out.reserve(count);
    while (out.size() < count) {
      const auto one = cursor_.number(kind, coding_);
      if (!one) return fail(out.size());
      out.push_back(*one);
    }
    return out;
  }

  Result<void> take_points(std::int64_t count, std::string_view type, std::string_view line) {
    const auto kind = vtk_kind(type);
    if (!kind || count > kMost) return reject("fewer than 2^31 points of a known type", line);
    const auto values = numbers(3 * static_cast<std::uint64_t>(count), *kind, "POINTS");
    if (!values) return values.error();
    for (std::size_t i = 0; i < values->size(); i += 3) {
      mesh_.add_point({(*values)[i], (*values)[i + 1], (*values)[i + 2]});
    }
    return {};
  }

  Result<std::vector<std::int64_t>> whole_numbers(std::int64_t count, const NumberKind& kind,
                                                  const std::string& what) {
    const auto values = numbers(static_cast<std::uint64_t>(count), kind, what);
    if (!values) return values.error();
    std::vector<std::int64_t> out;
    out.reserve(values->size());
    for (const double value : *values) {
      if (!(std::abs(value) <= kMost) || value != std::trunc(value)) {
        return malformed_surface(path_, "whole numbers of " + what, to_text(value));
      }
      out.push_back(static_cast<std::int64_t>(value));
    }
    return out;
  }

  void add_cell(std::string_view what, std::span<const std::int64_t> corners) {
    if (what == "POLYGONS") mesh_.add_polygon(corners);
    if (what == "TRIANGLE_STRIPS") mesh_.add_strip(corners);
  }

  Result<void> take_cells(const std::string& what, std::int64_t count, std::int64_t size) {
    if (modern_) return take_modern_cells(what, count, size);
    const auto all = whole_numbers(size, *vtk_kind("int"), what);
    if (!all) return all.error();
    std::span<const std::int64_t> left(*all);
    for (std::int64_t cell = 0; cell < count; ++cell) {
      const std::int64_t corners = left.empty() ? -1 : left[0];
      if (corners < 0 || corners >= static_cast<std::int64_t>(left.size())) {
        return malformed_surface(
            path_, std::to_string(count) + " " + what + " of " + std::to_string(size) + " numbers",
            std::to_string(cell));
      }
      add_cell(what, left.subspan(1, static_cast<std::size_t>(corners)));
      left = left.subspan(static_cast<std::size_t>(corners) + 1);
    }
    return {};
  }

  Result<std::vector<std::int64_t>> modern_array(const std::string& name, std::int64_t count,
                                                 const std::string& what) {
    const auto line = cursor_.filled_line();
    const auto words = split_words(line.value_or(""));
    const auto kind = words.size() == 2 ? vtk_kind(words[1]) : std::nullopt;
    if (!kind || !is(words[0], name)) return reject(name + " of " + what, line);
    return whole_numbers(count, *kind, name + " of " + what);
  }

  Result<void> take_modern_cells(const std::string& what, std::int64_t count, std::int64_t size) {
    const auto offsets = modern_array("OFFSETS", count, what);
    if (!offsets) return offsets.error();
    const auto corners = modern_array("CONNECTIVITY", size, what);
    if (!corners) return corners.error();
    for (std::size_t i = 1; i < offsets->size(); ++i) {
      const std::int64_t begin = (*offsets)[i - 1];
      const std::int64_t end = (*offsets)[i];
      if (begin < 0 || end < begin || end > size) {
        return malformed_surface(path_, "growing OFFSETS of " + what, std::to_string(end));
      }
      add_cell(what, std::span(*corners).subspan(static_cast<std::size_t>(begin),
                                                 static_cast<std::size_t>(end - begin)));
    }
    return {};
  }

  Result<void> skip_field(std::optional<std::int64_t> arrays, std::string_view line) {
    if (!arrays) return reject("FIELD with a number of arrays", line);
    for (std::int64_t i = 0; i < *arrays; ++i) {
      const auto head = cursor_.filled_line();
      const auto words = split_words(head.value_or(""));
      const auto components = words.size() == 4 ? parse_int(words[1]) : std::nullopt;
      const auto tuples = words.size() == 4 ? parse_int(words[2]) : std::nullopt;
      const auto kind = words.size() == 4 ? vtk_kind(words[3]) : std::nullopt;
      if (!kind || !components || !tuples || *components < 0 || *tuples < 0 ||
          *components > kMost || *tuples > kMost) {
        return reject("an array of numbers in FIELD", head);
      }
      const auto skipped =
          numbers(static_cast<std::uint64_t>(*components) * static_cast<std::uint64_t>(*tuples),
                  *kind, "FIELD");
      if (!skipped) return skipped.error();
    }
    return {};
  }

  static constexpr std::int64_t kMost = std::numeric_limits<int>::max();
  const std::filesystem::path& path_;
  SurfaceCursor cursor_;
  MeshBuilder mesh_;
  NumberCoding coding_ = NumberCoding::kText;
  bool modern_ = false;
};

}  // namespace

Result<TriangleMesh> read_legacy_vtk(const std::filesystem::path& path, std::string_view content) {
  return LegacyVtk(path, content).read();
}

}  // namespace nav::io::detail
