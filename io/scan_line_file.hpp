// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/scan_line.hpp"
#include "nav/volume.hpp"

namespace nav::io {

/// File of the scan lines of a volume's voxels: "us.mha" has "us.scan-lines.mha" beside it.
std::filesystem::path scan_lines_beside(const std::filesystem::path& volume);

/// Digest of the voxels of a volume: SHA-256 of its values, 16 bits each, i fastest.
std::string digest_of(const StoredVolume& volume);

/// Writes scan lines as a MetaImage of four 16-bit channels (words of ScanLineAtVoxel), atomically.
/// \p volume: the one that they belong to; its digest is kept in the header. Precondition: one line
/// for each voxel, otherwise a Bug.
Result<void> write_scan_lines(const StoredVolume& volume, std::span<const ScanLineAtVoxel> lines,
                              const std::filesystem::path& path);

/// Scan lines of a file.
struct ScanLineFile {
  std::vector<ScanLineAtVoxel> lines;  ///< i fastest.
  std::string volume_digest;           ///< The digest_of() their volume.
};
/// Reads such a file. kUnsupportedData when it is another kind of image or has more than 2^31
/// voxels. Blocks.
Result<ScanLineFile> read_scan_line_file(const std::filesystem::path& path);

}  // namespace nav::io
