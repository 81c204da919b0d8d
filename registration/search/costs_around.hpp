// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "registration/similarity/lc2_cost.hpp"
#include "registration/similarity/sweep_points.hpp"

namespace nav::registration {

/// How far about a pose its cost is asked, along and about each axis: shifts, and turns that move
/// the sweep's edge as far, mm.
inline constexpr double kAroundMm = 1;

/// Costs at a pose and about it, of at most 600 patches evenly chosen: more tell no better whether
/// a millimetre costs something.
struct CostsAround {
  /// One step beside the pose.
  struct Beside {
    Pose pose;
    CostTerms terms;  ///< As of here, and the gradient about the pose's own centre where asked for.
  };
  PatchSet patches;    ///< Every stride-th.
  std::size_t stride;  ///< >= 1.
  Pose pose;
  double turn_rad;  ///< That moves the sweep's edge by kAroundMm.
  CostTerms here;   ///< Cost and patch_costs.
  /// By axis of a twist, turns about Ct's axes first, then shifts along them; back and forth of
  /// each.
  std::vector<Beside> beside;

  /// Beside the pose along axis 0 to 2, side 0 back and 1 forth.
  [[nodiscard]] const Beside& shifted(std::size_t axis, std::size_t side) const {
    return beside[2 * (3 + axis) + side];
  }
};

/// gradients: those beside the pose too, for nearly twice the time.
CostsAround costs_around(const Lc2Cost& cost, const SweepPoints& sweep, const Pose& pose,
                         bool gradients = false);

}  // namespace nav::registration
