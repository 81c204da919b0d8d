// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::io {

/// Segmentation: a whole number of 0 to 2^32 - 1 for each voxel, exactly as in the file.
struct LabelFile {
  VoxelGrid grid;
  std::vector<std::uint32_t> values;  ///< Order: i fastest, then j, then k.
};

/// Reads NIfTI (.nii, .nii.gz), MetaImage (.mha, .mhd) or NRRD (.nrrd, .nhdr); real values are
/// accepted if they are whole. Rejects fractions, negative numbers, numbers above 2^32 - 1, NaN and
/// Inf by value and index, and the geometries that read_ct() rejects. Blocks; thread-safe.
Result<LabelFile> read_labels(const std::filesystem::path& path, Diagnostics& diagnostics);

}  // namespace nav::io
