// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "nav/result.hpp"
#include "render/scene.hpp"
#include "render/transfer/transfer_presets.hpp"

namespace nav::app {

/// Name of the component that is fitted to the blood of a CT.
inline constexpr const char* kVesselComponent = "vessels";

/// Appearance that can be stored and used with another data set: how values are classified, shaded
/// and cut away. It holds which kinds of objects cut, but not the objects themselves: these belong
/// to a procedure.
struct AppearanceFile {
  render::TransferFunction transfer;
  std::optional<render::Shading> shading;  ///< Absent: not in the file.
  /// Outer optional absent: not in the file. Inner optional absent: no cutaway.
  std::optional<std::optional<render::Cutaway>> cutaway;
  /// Value range of the volume that the appearance was made for; present when values have no
  /// absolute scale (MR).
  std::optional<render::ValueRange> value_range;
  /// The component "vessels" is fitted to the blood of each CT (render/transfer/vessel_fit.hpp).
  bool fit_vessels = false;
  /// True: nothing beside the body is drawn (render/transfer/body.hpp). Only for CT in HU.
  bool remove_table = false;
  /// Sigma of the Gaussian that smooths the CT for gradients, mm (render/transfer/smoothed_ct.hpp).
  double smoothing_mm = 0;
};

/// Reads Sonde's own JSON (docs/appearances.md) or 3D Slicer's volume properties, .vp and .vp.json;
/// the contents decide which. Rejects files that are broken, are larger than 1 MiB, have more than
/// 4096 nodes, or have numbers that are not finite or out of range. The message names the file, the
/// position, what was expected and what was found.
Result<AppearanceFile> read_appearance_file(const std::filesystem::path& path);

/// Reads Sonde's own JSON from a text. name: for messages.
Result<AppearanceFile> parse_appearance_text(const std::string& name, const std::string& text);

/// Appearance as Sonde's own JSON; read_appearance_file() returns the same values.
std::string to_json_text(const AppearanceFile& appearance);
/// Writes the appearance as JSON; the file appears only when it is complete.
Result<void> write_appearance_file(const std::filesystem::path& path,
                                   const AppearanceFile& appearance);

/// Appearance for a volume. When the file has a value range, the values of the transfer function
/// and the gradients of the shading, given or default, are mapped from look.value_range to the
/// volume's own range; otherwise they are absolute. Rejects nodes that become equal by this
/// mapping.
Result<AppearanceFile> appearance_for(AppearanceFile appearance, const Volume& volume);

}  // namespace nav::app
