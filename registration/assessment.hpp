// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "registration/similarity/similarity_cost.hpp"
#include "registration/similarity/sweep_points.hpp"

/// Measures of a result's quality besides its cost.
namespace nav::registration {

/// Half widths of the box of random poses that z_score() draws.
inline constexpr double kRandomPoseMm = 40;
inline constexpr double kRandomPoseRad = 0.6;

/// Fewer patches than this do not determine six unknowns reliably when some are outliers.
inline constexpr std::size_t kMinPatches = 20;

/// (mean cost of random poses about a pose − its cost) / their standard deviation; 0 if all of them
/// cost the same.
double z_score(const SimilarityCost& cost, const SweepPoints& sweep, const Pose& pose, int poses,
               std::uint64_t seed);

}  // namespace nav::registration
