// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "nav/result.hpp"
#include "nav/triangle_mesh.hpp"

namespace nav::io::detail {

enum class NumberCoding { kText, kLittleEndian, kBigEndian };

/// Format of a number in a binary file.
struct NumberKind {
  std::size_t bytes = 0;  ///< 1, 2, 4 or 8.
  bool real = false;
  bool has_sign = true;
};

/// Unread rest of a surface file; reading never passes its end.
class SurfaceCursor {
 public:
  explicit SurfaceCursor(std::string_view content) : rest_(content) {}

  /// Returns the next line without its end; nothing at the end of the file.
  std::optional<std::string_view> line();
  /// Returns the next line that is not blank.
  std::optional<std::string_view> filled_line();
  /// Returns the next number; nothing when there is none.
  std::optional<double> number(const NumberKind& kind, NumberCoding coding);
  /// True when that many numbers could remain.
  [[nodiscard]] bool may_hold(std::uint64_t numbers, const NumberKind& kind,
                              NumberCoding coding) const;

 private:
  std::string_view rest_;
};

/// Builds triangles from the polygons and strips of a file.
class MeshBuilder {
 public:
  explicit MeshBuilder(const std::filesystem::path& path) : mesh_{{}, {}, path.string()} {}

  void add_point(const Eigen::Vector3d& mm) { mesh_.points_mm.push_back(mm); }
  /// Adds a polygon as a fan about its first corner.
  void add_polygon(std::span<const std::int64_t> corners);
  /// Adds a strip; every other triangle is reversed, so that all have the same orientation.
  void add_strip(std::span<const std::int64_t> corners);
  /// Rejects corners that are not points of the file.
  [[nodiscard]] Result<TriangleMesh> take() &&;

 private:
  void add(std::int64_t a, std::int64_t b, std::int64_t c);
  TriangleMesh mesh_;
  std::int64_t least_ = 0;
  std::int64_t greatest_ = 0;
};

/// Error of malformed data: "<path>: expected <expected>, found <found>".
Error malformed_surface(const std::filesystem::path& path, const std::string& expected,
                        const std::string& found);
/// Error for an unexpected line; no line: the file ended.
Error unexpected_line(const std::filesystem::path& path, const std::string& expected,
                      const std::optional<std::string_view>& found);

/// Reads the polygons and strips of a legacy VTK file (DATASET POLYDATA, any version), in text or
/// binary. VTK's own readers crash on files that are cut short.
Result<TriangleMesh> read_legacy_vtk(const std::filesystem::path& path, std::string_view content);
/// Reads the faces of a PLY file, in text or binary of either byte order.
Result<TriangleMesh> read_ply(const std::filesystem::path& path, std::string_view content);
/// Reads an STL file by VTK, in text or binary. \p content: the whole file, which must be complete.
Result<TriangleMesh> read_stl(const std::filesystem::path& path, std::string_view content);

}  // namespace nav::io::detail
