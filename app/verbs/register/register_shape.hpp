// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "app/report.hpp"
#include "nav/result.hpp"
#include "registration/shape/shape_acceptance.hpp"

namespace nav::app {

/// Files of 'sonde register --points'.
struct ShapeFiles {
  std::filesystem::path points;        ///< Tracked, Reference, mm (io::read_point_groups).
  std::filesystem::path surface;       ///< Mesh in CT coordinates, or empty.
  std::filesystem::path centre_lines;  ///< Branches of vessels in CT coordinates, or empty; the
                                       ///< tracked points are then branches too.
  std::optional<double> sigma_mm;      ///< Standard deviation of the points; absent: not known.
  /// The start puts the points within this distance (RMS) of where they are; absent: not known.
  std::optional<double> start_within_mm;
};

/// Registers tracked points to a surface, or tracked vessels to centre lines, from a start pose.
/// Points that are left out go to the diagnostics. Errors name the file.
Result<registration::ShapeRegistration> register_shape_files(
    const ShapeFiles& files, const Transform<frames::Ct, frames::Reference>& start,
    Diagnostics& diagnostics);

/// JSON of a registration by surface or vessels (docs/json.md).
io::Json json_of(const registration::ShapeRegistration& result,
                 const registration::Decision& decision, const Point<frames::Ct>& target);

}  // namespace nav::app
