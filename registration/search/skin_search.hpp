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

/// Options of a search over all poses at which the probe could stand on the body in the CT: its
/// face on the skin and the ultrasound images inside the body. The search covers all skin positions
/// spacing_mm apart, all rotations about the beam, and inclinations of up to lean_rad.
struct SkinSearchOptions {
  double spacing_mm = 20;  ///< > 0.
  int turns = 12;          ///< Number of rotations about the beam, >= 1.
  double lean_rad = 0.35;  ///< [0, 1].
  int tried = 300;         ///< Number of poses that are tried for a few steps, >= 1.
  int followed = 4;        ///< Different positions that are followed to the second level, >= 1.
  /// Known orientation of the probe: direction of the left edge of the middle image, unit, Ct.
  /// Poses that deviate by more than marker_within_rad are not tried.
  std::optional<Eigen::Vector3d> marker_towards = {};
  double marker_within_rad = 0.8;  ///< (0, pi].
};

/// Returns an error that names the first option that is out of its range.
Result<void> validate(const SkinSearchOptions& options);

/// register_sweep() without a start pose. Every pose of the options is ranked by the similarity on
/// the first level; the surroundings of the best are searched as in register_sweep(), the best
/// positions are followed to the second level, and the best two that have not lost there are
/// registered to the end. The result is the one with the lowest cost; its margin counts the others.
/// options.time_limit_s limits the whole search. If it ends the search before a position was found,
/// the result is kTimeout; later it ends with the best result so far, which decide() rejects.
/// Errors: those of register_sweep(); kTimeout; kRefused if the CT shows no skin on which the sweep
/// fits in a position that \p search allows.
Result<ImageRegistrationResult> register_on_skin(
    const Volume& ct, const Sweep& sweep, const ImageRegistrationOptions& options,
    const SkinSearchOptions& search, Diagnostics& diagnostics,
    const std::function<bool(double fraction)>& progress = {});

}  // namespace nav::registration
