// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"

namespace nav::io {

/// A point that was set in 3D Slicer.
struct MarkupPoint {
  std::string name;        ///< Its label; may be empty.
  Eigen::Vector3d lps_mm;  ///< In the LPS of the scene, whatever the file has.
  bool placed = true;      ///< False: the file has no position for it.

  /// Its position in the RAS of the scene. 3D Slicer takes the coordinates of a tracker, and of a
  /// body that it tracks, as RAS.
  [[nodiscard]] Eigen::Vector3d ras_mm() const { return {-lps_mm.x(), -lps_mm.y(), lps_mm.z()}; }
};

/// Points of a Markups file.
struct Markups {
  std::vector<std::vector<MarkupPoint>> lists;  ///< Point lists and curves.
  std::vector<Finding> findings;                ///< Points without a position.
};

/// True for a name that ends as Markups files of 3D Slicer do: .fcsv, .mrk.json.
bool is_markups_file(const std::filesystem::path& path);

/// Reads a Markups file of 3D Slicer, by its name: a table (.fcsv) or JSON (.mrk.json), of points
/// in LPS or RAS, mm. Points without a position (undefined, preview, missing) are named in a
/// finding; at least one point has one. Errors: kMalformedData, which names file, line or member,
/// what was expected and what was found; those of read_file().
Result<Markups> read_markups(const std::filesystem::path& path);

}  // namespace nav::io
