// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "render/features/scribbles.hpp"
#include "render/scene.hpp"

namespace nav::app {

/// Strokes that were painted on slices of a volume (Schulte zu Berge et al. 2014 §4.1), as a file:
///   {"sonde_scribbles": 1,
///    "strokes": [{"paint": "show", "points_mm": [[x, y, z], ..], "normal": [0, 0, 1],
///                 "radius_mm": 1, "thickness_mm": 0.5}, ..]}
/// Points are LPS, on any slice; "paint" is show, hide or erase; "normal" is the slice's (absent:
/// of the plane through the points); "thickness_mm" is what the slice stands for (absent: one
/// voxel). Refuses files above 1 MiB, broken, of a newer version; the message names file, place,
/// what was expected and what was found.
Result<std::vector<render::features::Stroke>> read_scribble_file(const std::filesystem::path& path);

/// "x,y,z x,y,z …[ radius=MM][ thickness=MM][ normal=x,y,z]", LPS mm: a stroke of the command line.
/// kUsage, naming the option, for anything else and for numbers that a file may not have either.
Result<render::features::Stroke> parse_stroke(const std::string& option,
                                              render::features::Paint paint,
                                              const std::string& text);

/// Refuses strokes that leave their slices on such a grid, naming their number: what scribble()
/// would refuse, before there is a scene.
Result<void> check_strokes(const std::vector<render::features::Stroke>& strokes,
                           const VoxelGrid& grid);

/// What strokes did to a histogram.
struct ScribbleOutcome {
  render::PredicateHistogram histogram;  ///< After Eq. 9.
  std::size_t shown = 0;                 ///< Voxels.
  std::size_t hidden = 0;
  bool decisive = true;  ///< Some bar changed.
};

/// Paints strokes into a bit-mask volume on the scene's grid, counts which predicates are true
/// under them and changes the importances by Eq. 9. Refuses strokes that mark no voxel, naming
/// their number. Precondition: a scene whose predicates have their features.
Result<ScribbleOutcome> scribble(const render::Scene& scene,
                                 const std::vector<render::features::Stroke>& strokes,
                                 double share);

}  // namespace nav::app
