// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "app/look/look_file.hpp"

namespace nav::app {

/// 3D Slicer's volume properties as a look of one component, importance 1/2 everywhere (Slicer has
/// none: --importance adds it).
/// - Opacities are per scalarOpacityUnitDistance (.vp: 1 mm) and at most kMostOpaque.
/// - Points are sorted; equal ones are a step, as in Slicer. Midpoints and sharpness other than
///   those of VTK are refused: the curves they make are not piecewise linear.
/// - A gradient opacity that is one value throughout scales the opacity; one that rises from 0 to a
///   plateau and may fall back to 0 becomes a GradientWindow; any other is refused. VTK multiplies
///   opacity by it, Sonde extinction: on the ramps of the window an opaque material stays denser.
/// - Nearest-neighbour interpolation, several components and clipped voxels are not carried over.
inline constexpr double kMostOpaque = 0.9999;

/// name: file, for messages; also the look's name.
Result<LookFile> slicer_look_from_vp(const std::string& name, const std::string& text);
Result<LookFile> slicer_look_from_json(const std::string& name, const nlohmann::json& root);

}  // namespace nav::app
