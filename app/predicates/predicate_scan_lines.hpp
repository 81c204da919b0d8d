// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "app/console.hpp"
#include "nav/result.hpp"
#include "render/features/scan_lines.hpp"
#include "render/predicates/predicate_scene.hpp"

namespace nav::app {

/// Point where parallel scan lines have depth 0: the known voxel that lies furthest towards the
/// probe, or the nearest corner when all or no voxels are known. away: direction away from the
/// probe, of any finite length > 0. unknown: value of voxels that no image reached; absent: all
/// voxels are known.
Point<frames::Ct> nearest_voxel(const StoredVolume& volume, const Eigen::Vector3d& away,
                                std::optional<std::int16_t> unknown);

/// Reads the scan lines of a volume that was compounded from the images of a sweep
/// (sonde_scan_lines, docs/predicates.md). grid: of the volume. Rejects errors in the file, naming
/// the member, poses that are not rigid, and images that give no voxel a direction. Shows its
/// progress; Ctrl-C ends it with kCancelled. Main thread.
Result<render::features::ScanLines> read_scan_lines(const std::filesystem::path& path,
                                                    const VoxelGrid& grid, int threads,
                                                    Console& console);

/// Reads the scan lines that lie beside a volume of 'sonde reconstruct' (us.scan-lines.mha beside
/// us.mha). Absent when there is no such file, or when it belongs to other voxels, with a warning.
/// Rejects a damaged file. \p file: of the volume.
Result<std::optional<render::features::ScanLines>> scan_lines_beside(
    const std::filesystem::path& file, const StoredVolume& volume, Console& console);

/// Stored value of voxels that no image reached, of a volume of 'sonde reconstruct': \p given, or,
/// when it is absent, the value that the reconstruction marks them with, if a voxel has it.
std::optional<int> unknown_of_reconstruction(const StoredVolume& volume, std::optional<int> given);

/// Adds scan lines to the scene as add_scan_lines() does.
Result<void> add_lines(const render::features::ScanLines& lines, const VoxelGrid& grid, int threads,
                       render::PredicateScene& predicates);

/// Reads scan lines as read_scan_lines() does and adds them to the scene: directions per voxel to
/// predicates.scan, depths to its features. Rejects what read_scan_lines() rejects.
Result<void> add_scan_lines(const std::filesystem::path& path, const VoxelGrid& grid, int threads,
                            render::PredicateScene& predicates, Console& console);

}  // namespace nav::app
