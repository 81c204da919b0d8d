// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "nav/result.hpp"
#include "render/predicates/feature.hpp"

namespace nav::app {

/// Reads the labels of an ultrasound volume from layers between surfaces (sonde_layers,
/// docs/predicates.md). Surfaces are cubic B-spline heights along one axis of the grid, mm from the
/// first voxel's centre. Bit n of a label is set when the voxel lies behind n of the surfaces. The
/// result also holds the surfaces, for the engine that evaluates them exactly. Rejects errors in
/// the file, naming the member, and surfaces of another axis or size (render/features/labels.hpp).
Result<render::LabelVolume> read_layers(const std::filesystem::path& path, const VoxelGrid& grid);

}  // namespace nav::app
