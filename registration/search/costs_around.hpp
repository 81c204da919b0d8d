// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "registration/similarity/similarity_cost.hpp"
#include "registration/similarity/sweep_points.hpp"

namespace nav::registration {

/// Distance of the poses about a pose at which the cost is evaluated, along and about each axis,
/// mm: shifts, and rotations that move the sweep's edge by this distance.
inline constexpr double kAroundMm = 1;

/// Costs at a pose and about it, of at most 600 evenly chosen patches: more patches do not show
/// better how the cost changes over a millimetre.
struct CostsAround {
  /// A pose one step away.
  struct Beside {
    Pose pose;
    /// Terms like those of here. The gradient, if requested, is about the sweep's centroid at
    /// CostsAround::pose.
    CostTerms terms;
  };
  PatchSet patches;    ///< Every stride-th patch of the set.
  std::size_t stride;  ///< >= 1.
  Pose pose;
  double turn_rad;   ///< Angle that moves the sweep's edge by kAroundMm.
  CostTerms here{};  ///< cost and patch_costs at the pose.
  /// Sorted by axis of a twist: first rotations about the axes of Ct, then shifts along them; back
  /// and forth for each.
  std::vector<Beside> beside{};

  /// The pose that is shifted along axis 0 to 2; side 0 is back and 1 is forth.
  [[nodiscard]] const Beside& shifted(std::size_t axis, std::size_t side) const {
    return beside[2 * (3 + axis) + side];
  }
};

/// \p gradients: also compute the gradients of the poses beside, which nearly doubles the time.
CostsAround costs_around(const SimilarityCost& cost, const SweepPoints& sweep, const Pose& pose,
                         bool gradients = false);

}  // namespace nav::registration
