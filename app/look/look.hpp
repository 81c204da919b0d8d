// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/options/session_config.hpp"
#include "nav/diagnostics.hpp"
#include "nav/volume.hpp"
#include "render/scene.hpp"
#include "render/transfer/transfer_presets.hpp"

namespace nav::app {

/// A session's look for one volume: what a scene takes over as it is.
struct ResolvedLook {
  render::TransferFunction transfer;
  render::Shading shading;
  std::optional<render::Cutaway> cutaway;
  render::Projection projection = render::Projection::kComposite;
  /// Of the volume, where values of the transfer function are only true for it (MR).
  std::optional<render::ValueRange> value_range{};
};

/// Warns of components whose opacity lies between whole numbers, at which values are classified.
void warn_of_lost_components(const render::TransferFunction& transfer, Diagnostics& diagnostics);

/// Warns of a preset for Hounsfield units on a volume that seems to have none.
void warn_of_units(const SessionConfig::Look& look, const Volume& ct, Diagnostics& diagnostics);

/// Nothing for an empty path, else stores a look, to be carried to another data set: colours with
/// the importance that was laid over them, shading, and which kinds of objects cut.
Result<void> save_look(const std::filesystem::path& path, const ResolvedLook& look);

/// Reads the look file, if there is one, fits presets and files to the volume, and lays over them
/// what the session says. Refuses unknown presets, bad files and importance rules, and values that
/// contradict each other only now (theta1 of the session above theta2 of the file).
Result<ResolvedLook> resolve_look(const SessionConfig::Look& look, const Volume& ct);

}  // namespace nav::app
