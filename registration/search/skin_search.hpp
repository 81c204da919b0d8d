// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "nav/sweep.hpp"
#include "nav/volume.hpp"
#include "registration/image_registration.hpp"

namespace nav::registration {

/// Poses at which the probe could stand on the body that the CT shows: its face on the skin in
/// every picture, the pictures inside the body. All places, spacing_mm apart, all turns about the
/// beam, and leaning by up to lean_rad.
struct SkinSearchOptions {
  double spacing_mm = 20;  ///< > 0.
  int turns = 12;          ///< About the beam, >= 1.
  double lean_rad = 0.35;  ///< [0, 1].
  int tried = 300;         ///< Of the poses so many are tried for a few steps, >= 1.
  int followed = 4;        ///< Different places that are followed to the second level, >= 1.
  /// What is known of how the probe was held: where the left edge of the middle picture points,
  /// unit, Ct. Poses that are off by more than marker_within_rad are not among those tried.
  std::optional<Eigen::Vector3d> marker_towards = {};
  double marker_within_rad = 0.8;  ///< (0, pi].
};

/// A refusal that names the first option out of its range.
Result<void> validate(const SkinSearchOptions& options);

/// register_sweep() without a start pose. Every such pose is ranked by the similarity of the first
/// level; the surroundings of the best are searched as register_sweep() does, the best places are
/// followed to the second level, and the best two that have not lost there are registered to the
/// end. The answer is the cheapest of these; its margin counts the others.
/// options.time_limit_s is of the whole: a search that it ends without a place is kTimeout, what it
/// ends later is the best until then, which decide() refuses.
/// Errors: those of register_sweep(); kTimeout; kRefused where the CT shows no skin that the sweep
/// fits on, held as the options say.
Result<ImageRegistrationResult> register_on_skin(
    const Volume& ct, const Sweep& sweep, const ImageRegistrationOptions& options,
    const SkinSearchOptions& search, Diagnostics& diagnostics,
    const std::function<bool(double fraction)>& progress = {});

}  // namespace nav::registration
