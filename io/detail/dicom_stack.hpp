// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "io/detail/hu_builder.hpp"
#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::io::detail {

/// One picture of a DICOM series, not yet decoded.
struct DicomSlice {
  std::filesystem::path file;
  int frame = 0;                     ///< Index within a multi-frame file.
  Eigen::Vector3d position_mm;       ///< Centre of the first pixel, LPS.
  Eigen::Vector3d row_direction;     ///< Of growing column index, LPS.
  Eigen::Vector3d column_direction;  ///< Of growing row index, LPS.
  Eigen::Vector2d spacing_mm;        ///< Between columns, between rows.
  int columns = 0;
  int rows = 0;
  Rescale rescale;

  /// "CTHead12.dcm", with its frame where there are several.
  [[nodiscard]] std::string name() const;
};

/// Slices of one orientation in order along their normal, and what is irregular about them.
struct DicomStack {
  std::vector<DicomSlice> slices;
  Eigen::Matrix3d directions;          ///< Columns, rows, normal; right-handed.
  std::vector<Eigen::Vector3d> at_mm;  ///< Position of each slice along directions, from the first.
  bool regular = false;                ///< Even spacing, no drift within the plane.
  double tilt_rad = 0;                 ///< Between the stacking direction and the normal.
  double min_gap_mm = 0, max_gap_mm = 0;
  std::size_t max_gap_at = 0;  ///< The widest gap lies before this slice.

  /// Grid of a regular stack.
  [[nodiscard]] VoxelGrid grid() const;
};

/// Sorts and judges. Refuses, naming slices: fewer than two, mixed sizes, spacings or orientations,
/// two at one position, directions that are no rotation.
Result<DicomStack> stack_slices(std::vector<DicomSlice> slices, const std::string& name);

/// Regular orthogonal grid that covers a tilted or unevenly spaced stack; slices as thin as its
/// narrowest gap, but not thinner than its pixels are wide.
VoxelGrid regular_grid(const DicomStack& stack);

/// Voxels of that grid by linear interpolation between the true positions; air where no slice is.
/// hu: the slices in order of the stack.
std::vector<std::int16_t> resample(const DicomStack& stack, const std::vector<std::int16_t>& hu,
                                   const VoxelGrid& grid);

}  // namespace nav::io::detail
