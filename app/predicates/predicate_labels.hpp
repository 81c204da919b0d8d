// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "render/predicates/feature.hpp"

namespace nav::app {

/// Reads the labels of an ultrasound volume from files (NIfTI, MetaImage, NRRD). The values of a
/// single file are bit masks, 0 to 2^32 - 1. With several files, at most 32, file n gives bit n,
/// set wherever its value is not 0; segmentation programs write such files. Rejects grids that
/// differ from the volume's grid, naming both, and values that are not masks.
Result<render::LabelVolume> read_labels(const std::vector<std::filesystem::path>& files,
                                        const VoxelGrid& grid, Diagnostics& diagnostics);

}  // namespace nav::app
