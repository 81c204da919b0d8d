// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "io/detail/surface_cursor.hpp"
#include "io/detail/text.hpp"

namespace nav::io::detail {

namespace {

std::optional<NumberKind> ply_kind(std::string_view name) {
  struct Known {
    std::string_view name, other;
    NumberKind kind;
  };
  constexpr std::array kKnown = {
      Known{"char", "int8", {1, false, true}},    Known{"uchar", "uint8", {1, false, false}},
      Known{"short", "int16", {2, false, true}},  Known{"ushort", "uint16", {2, false, false}},
      Known{"int", "int32", {4, false, true}},    Known{"uint", "uint32", {4, false, false}},
      Known{"float", "float32", {4, true, true}}, Known{"double", "float64", {8, true, true}}};
  for (const Known& known : kKnown) {
    if (known.name == name || known.other == name) return known.kind;
  }
  return {};
}

struct Property {
  std::string_view name;
  NumberKind kind;
  std::optional<NumberKind> length;  ///< Type of the length of a list.
};

struct PlyElement {
  std::string_view name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

/// Reader of PLY files. Format: "The PLY Polygon File Format" of Greg Turk.
class Ply {
 public:
  Ply(const std::filesystem::path& path, std::string_view content)
      : path_(path), cursor_(content), mesh_(path) {}

  Result<TriangleMesh> read() {
    if (const auto ok = read_header(); !ok) return ok.error();
    for (const PlyElement& element : elements_) {
      if (const auto ok = read_element(element); !ok) return ok.error();
    }
    return std::move(mesh_).take();
  }

 private:
  Error reject(const std::string& expected, const std::optional<std::string_view>& found) const {
    return unexpected_line(path_, expected, found);
  }

  Result<void> read_header() {
    const auto magic = cursor_.line();
    if (!magic || trim(*magic) != "ply") return reject("'ply'", magic);
    for (;;) {
      const auto line = cursor_.line();
      if (!line) return reject("end_header", line);
      const auto words = split_words(*line);
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      const bool ok = words[0] == "format"     ? take_format(words)
                      : words[0] == "element"  ? take_element(words)
                      : words[0] == "property" ? take_property(words)
                                               : false;
      if (!ok) return reject("a format, element or property of PLY", *line);
    }
    if (!coding_) return reject("a format of PLY", "none");
    return {};
  }

  bool take_format(const std::vector<std::string_view>& words) {
    if (words.size() != 3) return false;
    if (words[1] == "ascii") coding_ = NumberCoding::kText;
    if (words[1] == "binary_little_endian") coding_ = NumberCoding::kLittleEndian;
    if (words[1] == "binary_big_endian") coding_ = NumberCoding::kBigEndian;
    return coding_.has_value();
  }

  bool take_element(const std::vector<std::string_view>& words) {
    const auto count = words.size() == 3 ? parse_int(words[2]) : std::nullopt;
    if (!count || *count < 0) return false;
    elements_.push_back({words[1], *count, {}});
    return true;
  }

  bool take_property(const std::vector<std::string_view>& words) {
    if (elements_.empty()) return false;
    const bool list = words.size() == 5 && words[1] == "list";
    if (!list && words.size() != 3) return false;
    const auto kind = ply_kind(words[list ? 3 : 1]);
    const auto length = list ? ply_kind(words[2]) : std::nullopt;
    if (!kind || (list && (!length || length->real))) return false;
    elements_.back().properties.push_back({words.back(), *kind, length});
    return true;
  }

  Result<void> read_element(const PlyElement& element) {
    const bool vertices = element.name == "vertex";
    const bool faces = element.name == "face";
    // An element without properties occupies no bytes, so its count may be arbitrary.
    if (element.properties.empty()) return {};
    for (std::int64_t i = 0; i < element.count; ++i) {
      Eigen::Vector3d point = Eigen::Vector3d::Constant(std::nan(""));
      for (const Property& property : element.properties) {
        if (!read_property(property)) {
          return malformed_surface(
              path_, std::to_string(element.count) + " of the element " + excerpt(element.name),
              std::to_string(i) + " that can be read");
        }
        constexpr std::string_view kAxes = "xyz";
        const auto axis = property.name.size() == 1 ? kAxes.find(property.name) : kAxes.npos;
        if (vertices && !property.length && axis != kAxes.npos) {
          point[static_cast<Eigen::Index>(axis)] = number_;
        }
        const bool corners = property.name == "vertex_indices" || property.name == "vertex_index";
        if (faces && property.length && corners) mesh_.add_polygon(list_);
      }
      if (vertices) mesh_.add_point(point);
    }
    return {};
  }

  /// Reads into number_ or list_; false when it cannot be read.
  bool read_property(const Property& property) {
    if (!property.length) {
      const auto value = cursor_.number(property.kind, *coding_);
      number_ = value.value_or(0);
      return value.has_value();
    }
    list_.clear();
    const auto length = cursor_.number(*property.length, *coding_);
    if (!length || !(*length >= 0 && *length <= kMost) || *length != std::trunc(*length)) {
      return false;
    }
    for (auto left = static_cast<std::int64_t>(*length); left > 0; --left) {
      const auto value = cursor_.number(property.kind, *coding_);
      if (!value || !(std::abs(*value) <= kMost) || *value != std::trunc(*value)) return false;
      list_.push_back(static_cast<std::int64_t>(*value));
    }
    return true;
  }

  static constexpr double kMost = 2147483647;
  const std::filesystem::path& path_;
  SurfaceCursor cursor_;
  MeshBuilder mesh_;
  std::optional<NumberCoding> coding_;
  std::vector<PlyElement> elements_;
  double number_ = 0;
  std::vector<std::int64_t> list_;
};

}  // namespace

Result<TriangleMesh> read_ply(const std::filesystem::path& path, std::string_view content) {
  return Ply(path, content).read();
}

}  // namespace nav::io::detail
