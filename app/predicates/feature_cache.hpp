// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "nav/diagnostics.hpp"
#include "render/features/service.hpp"

namespace nav::app {

/// Derived volumes in a folder, one file for each. The file is named after the digest of everything
/// that the volume depends on: voxels, grid, feature, parameters, scan lines and version of the
/// definition (render::features::key_of). It holds a line with its key and sizes, the note, the
/// values (32-bit floats, little-endian) and the SHA-256 of all of these. Files appear only when
/// complete, so several programs may share a folder. Nothing is ever removed.
class FeatureCache {
 public:
  explicit FeatureCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Reads the volume of a request; absent when the folder has none. A file that is cut short,
  /// changed or from another program is reported as a warning and never used.
  [[nodiscard]] std::optional<render::features::DerivedVolume> find(
      const render::features::DerivedRequest& request, Diagnostics& diagnostics) const;
  /// Stores a volume; creates the folder when it is missing. Failure to write is a warning.
  void keep(const render::features::DerivedRequest& request,
            const render::features::DerivedVolume& volume, Diagnostics& diagnostics) const;
  /// Path of the file for a request; the file need not exist.
  [[nodiscard]] std::filesystem::path path_of(
      const render::features::DerivedRequest& request) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace nav::app
