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

/// A segmentation: a whole number of 0 to 2^32 - 1 per voxel, exactly as the file says it.
struct LabelFile {
  VoxelGrid grid;
  std::vector<std::uint32_t> values;  ///< i fastest, then j, then k.
};

/// Reads NIfTI (.nii, .nii.gz), MetaImage (.mha, .mhd) or NRRD (.nrrd, .nhdr), reals too where they
/// are whole. Refuses fractions, negative numbers, numbers above 2^32 - 1, NaN and Inf by value and
/// index, and whatever read_ct does of the geometry. Blocks; thread-safe.
Result<LabelFile> read_labels(const std::filesystem::path& path, Diagnostics& diagnostics);

}  // namespace nav::io
