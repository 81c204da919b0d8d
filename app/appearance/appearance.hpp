// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/appearance/fitted_vessels.hpp"
#include "app/options/session_config.hpp"
#include "nav/diagnostics.hpp"
#include "nav/volume.hpp"
#include "render/scene.hpp"
#include "render/transfer/transfer_presets.hpp"

namespace nav::app {

/// Volume and colours that the 3D view draws in place of the CT as it is. Slices and registration
/// use the CT.
struct DrawnCt {
  std::shared_ptr<const Volume> ct;  ///< For drawing only; not in HU where bone was moved.
  render::TransferFunction transfer;
  /// Scene::gradient_source; null: the gradients are those of ct.
  std::shared_ptr<const StoredVolume> gradient_source{};
  std::vector<std::string> statements{};  ///< One sentence for each thing that was done.
};

/// Appearance of one volume in a session, in the form that a scene uses.
struct ResolvedAppearance {
  render::TransferFunction transfer;
  render::Shading shading;
  std::optional<render::Cutaway> cutaway;
  render::Projection projection = render::Projection::kComposite;
  /// Value range of the volume; present when the values of the transfer function hold only for this
  /// volume (MR).
  std::optional<render::ValueRange> value_range{};
  /// The component "vessels" is fitted to the blood of each CT that is drawn.
  bool fit_vessels = false;
  /// True: nothing beside the body is drawn.
  bool remove_table = false;
  /// Smoothing of the gradients, mm; 0: none.
  double smoothing_mm = 0;
  /// CT and function that are drawn instead; absent if the CT is drawn as it is.
  std::optional<DrawnCt> drawn{};
};

/// Warns of components that are opaque only between whole numbers: values are classified at whole
/// numbers, so these components are lost.
void warn_of_lost_components(const render::TransferFunction& transfer, Diagnostics& diagnostics);

/// Warns when the folder of the presets is missing and the default is a built-in preset therefore.
void warn_of_missing_presets(const SessionConfig::Appearance& appearance, const Volume& ct,
                             Diagnostics& diagnostics);

/// False when the session names an appearance that may be for values in another unit: a preset for
/// MR, a file, or nodes.
bool draws_hounsfield_units(const SessionConfig::Appearance& appearance);

/// Stores an appearance for use with another data set: colours with the importance of the session,
/// shading, and the kinds of objects that cut. Does nothing when the path is empty.
Result<void> save_appearance(const std::filesystem::path& path,
                             const ResolvedAppearance& appearance);

/// Name of the preset that is drawn: that of the session, or for "contextual" the one for the
/// volume's unit; a built-in one if the folder of the presets is missing.
std::string preset_name(const SessionConfig::Appearance& appearance, const Volume& ct);

/// Reads the appearance file, if there is one, fits the preset or file to the volume and applies
/// the session's settings on top. Rejects unknown presets, bad files and importance rules, and
/// values that contradict each other only in combination (theta1 of the session above theta2 of the
/// file).
Result<ResolvedAppearance> resolve_appearance(const SessionConfig::Appearance& appearance,
                                              const Volume& ct);

}  // namespace nav::app
