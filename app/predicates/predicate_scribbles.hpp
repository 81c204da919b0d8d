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

/// Reads strokes that were painted on slices of a volume (Schulte zu Berge et al. 2014 §4.1):
///   {"sonde_scribbles": 1,
///    "strokes": [{"paint": "show", "points_mm": [[x, y, z], ..], "normal": [0, 0, 1],
///                 "radius_mm": 1, "thickness_mm": 0.5}, ..]}
/// Points are LPS, on any slice. "paint" is show, hide or erase. "normal" is the normal of the
/// slice (absent: of the plane through the points). "thickness_mm" is the thickness of the slice
/// (absent: one voxel). Rejects files that are larger than 1 MiB, broken or of a newer version. The
/// message names the file, the position, what was expected and what was found.
Result<std::vector<render::features::Stroke>> read_scribble_file(const std::filesystem::path& path);

/// Reads the same from a text. name: for messages.
Result<std::vector<render::features::Stroke>> parse_scribble_text(const std::string& name,
                                                                  const std::string& text);
/// Strokes as JSON, which parse_scribble_text() reads.
std::string to_json_text(const std::vector<render::features::Stroke>& strokes);

/// Parses a stroke of the command line: "x,y,z x,y,z …[ radius=MM][ thickness=MM][ normal=x,y,z]",
/// LPS mm. Returns kUsage, naming the option, for anything else and for numbers that are not
/// allowed in a file.
Result<render::features::Stroke> parse_stroke(const std::string& option,
                                              render::features::Paint paint,
                                              const std::string& text);

/// Rejects strokes that leave their slices on this grid, naming their number. scribble() would
/// reject them too, but it needs a scene.
Result<void> check_strokes(const std::vector<render::features::Stroke>& strokes,
                           const VoxelGrid& grid);

/// Effect of strokes on a histogram.
struct ScribbleOutcome {
  render::PredicateHistogram histogram;  ///< After Eq. 9.
  std::size_t shown = 0;                 ///< Voxels marked to be shown.
  std::size_t hidden = 0;                ///< Voxels marked to be hidden.
  bool decisive = true;                  ///< Some bar changed.
};

/// Paints strokes into a bit-mask volume on the scene's grid, counts which predicates are true
/// under them and changes the importances by Eq. 9. share: q of Eq. 9, (0, 1]. Rejects strokes that
/// mark no voxel, naming their number. Precondition: a scene whose predicates have their features.
Result<ScribbleOutcome> scribble(const render::Scene& scene,
                                 const std::vector<render::features::Stroke>& strokes,
                                 double share);

}  // namespace nav::app
