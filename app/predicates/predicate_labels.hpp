// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "render/predicates/feature.hpp"

namespace nav::app {

/// Labels of an ultrasound volume from files (NIfTI, MetaImage, NRRD). One file: its values are bit
/// masks, 0 to 2^32 - 1. Several, at most 32: file n gives bit n, set where its value is not 0, as
/// segmentation programs write them. Refuses grids other than the volume's, naming both sizes, and
/// values that are no masks.
Result<render::LabelVolume> read_labels(const std::vector<std::filesystem::path>& files,
                                        const VoxelGrid& grid, Diagnostics& diagnostics);

}  // namespace nav::app
