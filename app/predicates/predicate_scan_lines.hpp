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

/// Where parallel scan lines have depth 0: the known voxel that lies furthest towards the probe, or
/// the corner of a volume of which all or nothing is known. away: from the probe, of any finite
/// length > 0. unknown: value of voxels that no picture reached.
Point<frames::Ct> nearest_voxel(const Volume& volume, const Eigen::Vector3d& away,
                                std::optional<std::int16_t> unknown);

/// Scan lines of a volume of that grid that was compounded from the pictures of a sweep
/// (sonde_scan_lines, docs/predicates.md). Refuses whatever the file gets wrong, naming the member,
/// poses that are not rigid, and pictures that leave no voxel a direction. Shows how far it is;
/// Ctrl-C ends it with kCancelled. Main thread.
Result<render::features::ScanLines> read_scan_lines(const std::filesystem::path& path,
                                                    const VoxelGrid& grid, int threads,
                                                    Console& console);

/// Scan lines of a volume that was compounded from the pictures of a sweep (sonde_scan_lines,
/// docs/predicates.md): directions per voxel into predicates.scan, depths into its features.
/// Refuses as read_scan_lines().
Result<void> add_scan_lines(const std::filesystem::path& path, const VoxelGrid& grid, int threads,
                            render::PredicateScene& predicates, Console& console);

}  // namespace nav::app
