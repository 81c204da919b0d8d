// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/ct.hpp"
#include "io/detail/voxel_sink.hpp"

namespace nav::io::detail {

/// How the readers take the values of a volume. The defaults are those of a CT.
struct VolumeReading : CtOptions {
  /// Least number of slices in a file other than DICOM. A single slice is not a CT, but may be
  /// ultrasound.
  int least_slices = 2;
  /// Unit of the values, for messages; empty: stored values of another kind, without a unit.
  std::string unit = "HU";
  std::int16_t least = kAirHu;  ///< Lower values are set to it: they are padding, not tissue.
};

/// Reads all voxels of a MetaImage or NRRD into \p sink and returns their grid.
Result<VoxelGrid> read_image_file_voxels(const std::filesystem::path& path, VoxelSink& sink,
                                         Diagnostics& diagnostics, const VolumeReading& options);
/// Reads NIfTI-1 or -2, a single file, plain or gzip.
Result<VoxelGrid> read_nifti_voxels(const std::filesystem::path& path, VoxelSink& sink,
                                    Diagnostics& diagnostics, const VolumeReading& options);
/// Reads either format, by the file's ending; nothing when the ending is neither.
std::optional<Result<VoxelGrid>> read_voxels(const std::filesystem::path& path, VoxelSink& sink,
                                             Diagnostics& diagnostics,
                                             const VolumeReading& options);
/// Reads one series among files; files that are not DICOM are skipped. \p name: name of the series
/// in messages.
Result<StoredVolume> read_ct_dicom(const std::vector<std::filesystem::path>& files,
                                   const std::string& name, Diagnostics& diagnostics,
                                   const VolumeReading& options);

/// Handles a file without axis orientation for read_ct(): a warning when the caller accepts it,
/// otherwise an error.
Result<void> unknown_orientation(const std::filesystem::path& path, const std::string& found,
                                 Diagnostics& diagnostics, const CtOptions& options);

}  // namespace nav::io::detail
