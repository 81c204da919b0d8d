// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "io/ct.hpp"
#include "io/detail/input_file.hpp"
#include "io/detail/voxel_sink.hpp"

namespace nav::io::detail {

/// All voxels of a MetaImage or NRRD, and where they lie.
Result<VoxelGrid> read_image_file_voxels(const std::filesystem::path& path, VoxelSink& sink,
                                         Diagnostics& diagnostics, const CtOptions& options);
/// NIfTI-1 or -2, single file, plain or gzip.
Result<VoxelGrid> read_nifti_voxels(const std::filesystem::path& path, VoxelSink& sink,
                                    Diagnostics& diagnostics, const CtOptions& options);
/// One of both, by its ending; nothing when that says neither.
std::optional<Result<VoxelGrid>> read_voxels(const std::filesystem::path& path, VoxelSink& sink,
                                             Diagnostics& diagnostics, const CtOptions& options);
/// One series among files; those that are not DICOM are passed over. name: what to call them.
Result<Volume> read_ct_dicom(const std::vector<std::filesystem::path>& files,
                             const std::string& name, Diagnostics& diagnostics,
                             const CtOptions& options);
/// True for a DICOM file, with or without the preamble of part 10; with it, for a broken one too.
bool is_dicom(const InputFile& file);

/// What read_ct does where a file does not say how its axes lie in the patient: a warning when the
/// caller accepts that, otherwise a refusal.
Result<void> unknown_orientation(const std::filesystem::path& path, const std::string& found,
                                 Diagnostics& diagnostics, const CtOptions& options);

}  // namespace nav::io::detail
