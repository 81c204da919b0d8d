// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::io::detail {

/// Writes a MetaImage of 16-bit values with exact geometry, atomically. \p channels: values per
/// voxel. \p fields: further lines of the header, "Key = value\n" each.
Result<void> write_meta_image(const VoxelGrid& grid, int channels, const std::string& fields,
                              std::span<const std::byte> bytes, bool compress,
                              const std::filesystem::path& path);

}  // namespace nav::io::detail
