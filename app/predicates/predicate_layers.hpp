// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "nav/result.hpp"
#include "render/predicates/feature.hpp"

namespace nav::app {

/// Labels of an ultrasound volume from layers between surfaces (sonde_layers, docs/predicates.md):
/// cubic B-spline heights along one axis of the grid, mm from the first voxel's centre; bit n of a
/// label: the voxel lies behind n of the surfaces. The surfaces come with them, for the engine that
/// evaluates them exactly. Refuses whatever the file gets wrong, naming the
/// member, and surfaces of another axis or size (render/features/labels.hpp).
Result<render::LabelVolume> read_layers(const std::filesystem::path& path, const VoxelGrid& grid);

}  // namespace nav::app
