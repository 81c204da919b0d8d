// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "nav/result.hpp"
#include "nav/triangle_mesh.hpp"

namespace nav::io {

/// Reads a surface of at most 1 GiB from a legacy VTK (.vtk), STL (.stl) or PLY (.ply) file.
/// Polygons become fans of triangles; strips become single triangles. Coordinates are mm, LPS
/// unless the file's title or comments contain SPACE=RAS. Errors: kNotFound, kUnsupportedData
/// (another ending or space), kMalformedData (not readable, cut short, no triangles). The message
/// names the file.
Result<TriangleMesh> read_surface(const std::filesystem::path& path);

/// Reads points from text: three numbers in each line, separated by blanks, commas or semicolons
/// (then a comma is a decimal point), mm. The first line may name the columns. Lines that begin
/// with # are comments. An empty line ends a group (a branch of a vessel tree) and
/// begins the next one. Errors name file and line.
Result<std::vector<std::vector<Eigen::Vector3d>>> read_point_groups(
    const std::filesystem::path& path);

}  // namespace nav::io
