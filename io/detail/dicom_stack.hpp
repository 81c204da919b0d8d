// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/detail/hu_builder.hpp"
#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::io::detail {

/// Attributes by which the images of two acquisitions or phases of one series differ.
inline constexpr std::array<const char*, 6> kPhaseKeys{"AcquisitionNumber",
                                                       "TemporalPositionIdentifier",
                                                       "KVP",
                                                       "ConvolutionKernel",
                                                       "AcquisitionTime",
                                                       "ContentTime"};
/// Those from here on are times, which may differ from slice to slice.
inline constexpr std::size_t kPhaseTimes = 4;

/// One image of a DICOM series, not yet decoded.
struct DicomSlice {
  std::filesystem::path file;
  int frame = 0;                     ///< Index within a multi-frame file.
  Eigen::Vector3d position_mm;       ///< Centre of the first pixel, LPS.
  Eigen::Vector3d row_direction;     ///< Direction of increasing column index, LPS.
  Eigen::Vector3d column_direction;  ///< Direction of increasing row index, LPS.
  Eigen::Vector2d spacing_mm;        ///< Spacing of columns, then of rows.
  int columns = 0;
  int rows = 0;
  std::array<std::string, 6> phase;      ///< Values of kPhaseKeys; empty when absent.
  std::string frame_of_reference;        ///< FrameOfReferenceUID; empty when absent.
  double stated_gap_mm = 0;              ///< SpacingBetweenSlices; 0 when absent.
  std::optional<std::int64_t> instance;  ///< InstanceNumber.
  Rescale rescale;

  /// Name such as "CTHead12.dcm", with the frame number in a multi-frame file.
  [[nodiscard]] std::string name() const;
};

/// Slices of one orientation in order along their normal, with their irregularities.
struct DicomStack {
  std::vector<DicomSlice> slices;
  Eigen::Matrix3d directions;          ///< Columns, rows, normal; right-handed.
  std::vector<Eigen::Vector3d> at_mm;  ///< Position of each slice along directions, from the first.
  bool regular = false;                ///< True for even spacing without drift within the plane.
  double tilt_rad = 0;                 ///< Angle between the stacking direction and the normal.
  double min_gap_mm = 0, max_gap_mm = 0;
  std::size_t max_gap_at = 0;  ///< The widest gap lies before this slice.

  /// Grid of a regular stack.
  [[nodiscard]] VoxelGrid grid() const;
};

/// Sorts and checks slices. Rejects, with their names: fewer than two slices, mixed sizes, spacings
/// or orientations, two slices at one position, and directions that are not a rotation.
Result<DicomStack> stack_slices(std::vector<DicomSlice> slices, const std::string& name);

/// Regular orthogonal grid that covers a tilted or unevenly spaced stack. The slice thickness is
/// the narrowest gap, but at least the pixel width.
VoxelGrid regular_grid(const DicomStack& stack);

/// Voxels of the regular grid, by linear interpolation between the true positions; air outside the
/// slices. \p hu: the slices in order of the stack.
std::vector<std::int16_t> resample(const DicomStack& stack, const std::vector<std::int16_t>& hu,
                                   const VoxelGrid& grid);

}  // namespace nav::io::detail
