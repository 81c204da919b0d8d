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

/// How a number lies in a binary file.
struct NumberKind {
  std::size_t bytes = 0;  ///< 1, 2, 4 or 8.
  bool real = false;
  bool has_sign = true;
};

/// What is left to read of a surface file; never reads beyond its end.
class SurfaceCursor {
 public:
  explicit SurfaceCursor(std::string_view content) : rest_(content) {}

  /// The next line without its end; nothing at the end of the file.
  std::optional<std::string_view> line();
  /// The next one that is not blank.
  std::optional<std::string_view> filled_line();
  /// The next number; nothing where there is none.
  std::optional<double> number(const NumberKind& kind, NumberCoding coding);
  /// Whether that many numbers could be left.
  [[nodiscard]] bool may_hold(std::uint64_t numbers, const NumberKind& kind,
                              NumberCoding coding) const;

 private:
  std::string_view rest_;
};

/// Triangles as polygons and strips of a file come.
class MeshBuilder {
 public:
  explicit MeshBuilder(const std::filesystem::path& path) : mesh_{{}, {}, path.string()} {}

  void add_point(const Eigen::Vector3d& mm) { mesh_.points_mm.push_back(mm); }
  /// A fan about the first corner.
  void add_polygon(std::span<const std::int64_t> corners);
  /// Every other triangle of a strip is written the other way round.
  void add_strip(std::span<const std::int64_t> corners);
  /// Refuses corners that are no points of the file.
  [[nodiscard]] Result<TriangleMesh> take() &&;

 private:
  void add(std::int64_t a, std::int64_t b, std::int64_t c);
  TriangleMesh mesh_;
  std::int64_t least_ = 0;
  std::int64_t greatest_ = 0;
};

/// "<path>: expected <expected>, found <found>", malformed.
Error malformed_surface(const std::filesystem::path& path, const std::string& expected,
                        const std::string& found);
/// The same of a line; nothing: the file ended.
Error unexpected_line(const std::filesystem::path& path, const std::string& expected,
                      const std::optional<std::string_view>& found);

/// The polygons and strips of a legacy VTK file (DATASET POLYDATA, of any version), in text or
/// binary. The readers of VTK crash on files that are cut short.
Result<TriangleMesh> read_legacy_vtk(const std::filesystem::path& path, std::string_view content);
/// The faces of a PLY file, in text or binary of both orders.
Result<TriangleMesh> read_ply(const std::filesystem::path& path, std::string_view content);

}  // namespace nav::io::detail
