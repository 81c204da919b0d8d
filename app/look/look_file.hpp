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

/// A look that can be stored and carried to another data set: how values are classified, shaded and
/// cut away. Objects of a cutaway belong to a procedure and are not part of it, only which kinds
/// cut.
struct LookFile {
  render::TransferFunction transfer;
  std::optional<render::Shading> shading;  ///< Absent: the file does not say.
  /// Absent: the file does not say. Inner absence: no cutaway.
  std::optional<std::optional<render::Cutaway>> cutaway;
  /// The value range of the volume that it was made for, where values have no absolute scale (MR).
  std::optional<render::ValueRange> value_range;
};

/// Reads Sonde's own JSON (docs/look-file.md) or 3D Slicer's volume properties, .vp and .vp.json;
/// the contents decide which. Refuses files above 1 MiB, above 4096 nodes, broken, with numbers
/// that are not finite or out of range; the message names file, place, what was expected and what
/// was found.
Result<LookFile> read_look_file(const std::filesystem::path& path);

/// Sonde's own JSON of a look; read_look_file() gives back the same values.
std::string to_json_text(const LookFile& look);
/// Writes it; the file appears when it is complete.
Result<void> write_look_file(const std::filesystem::path& path, const LookFile& look);

/// The look for a volume: values of the transfer function and gradients of the shading, said or
/// not, are carried over from look.value_range to the volume's own where the file has one;
/// otherwise they are absolute. Refuses nodes that fall together there.
Result<LookFile> look_for(LookFile look, const Volume& volume);

}  // namespace nav::app
