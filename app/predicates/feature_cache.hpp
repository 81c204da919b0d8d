// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "nav/diagnostics.hpp"
#include "render/features/service.hpp"

namespace nav::app {

/// Derived volumes in a folder, each in a file named after the digest of everything that it depends
/// on: voxels, grid, feature, parameters, scan lines, version of the definition
/// (render::features::key_of). A file holds a line with its key and sizes, the note, the values
/// (32-bit floats, little-endian) and the SHA-256 of all that. Files appear whole or not at all,
/// so that several programs may share a folder; nothing is ever removed.
class FeatureCache {
 public:
  explicit FeatureCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Absent where there is none. A file that is cut short, changed or not of this program is
  /// reported as a warning and never used.
  [[nodiscard]] std::optional<render::features::DerivedVolume> find(
      const render::features::DerivedRequest& request, Diagnostics& diagnostics) const;
  /// Makes the folder where it is missing. What cannot be written is reported as a warning.
  void keep(const render::features::DerivedRequest& request,
            const render::features::DerivedVolume& volume, Diagnostics& diagnostics) const;
  /// The file of a request, there or not.
  [[nodiscard]] std::filesystem::path path_of(
      const render::features::DerivedRequest& request) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace nav::app
