// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "app/appearance/appearance_file.hpp"

namespace nav::app {

/// Limit of opacities that come from 3D Slicer's volume properties. The properties become an
/// appearance of one component, with importance 1/2 everywhere (Slicer has no importance;
/// --importance adds it).
/// - Opacities are per scalarOpacityUnitDistance (.vp: 1 mm) and at most kMostOpaque.
/// - Points are sorted; equal points make a step, as in Slicer. Midpoints and sharpness other than
///   the defaults of VTK are rejected: their curves are not piecewise linear.
/// - A constant gradient opacity scales the opacity. One that rises from 0 to a plateau and may
/// fall
///   back to 0 becomes a GradientWindow. Any other is rejected. VTK multiplies opacity by it, Sonde
///   multiplies extinction: on the ramps of the window an opaque material stays denser.
/// - Nearest-neighbour interpolation, several components and clipped voxels are not supported.
inline constexpr double kMostOpaque = 0.9999;

/// Appearance from the text of a .vp file. name: of the file, for messages; also the name of the
/// appearance.
Result<AppearanceFile> slicer_appearance_from_vp(const std::string& name, const std::string& text);
/// Appearance from the root object of a .vp.json file. name: as above.
Result<AppearanceFile> slicer_appearance_from_json(const std::string& name,
                                                   const nlohmann::json& root);

}  // namespace nav::app
