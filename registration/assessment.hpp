// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "registration/lc2_cost.hpp"
#include "registration/sweep_points.hpp"

/// What a result says of itself besides its cost.
namespace nav::registration {

/// Half widths of the box of random poses of z_score().
inline constexpr double kRandomPoseMm = 40;
inline constexpr double kRandomPoseRad = 0.6;

/// Fewer patches than this do not hold six unknowns against outliers.
inline constexpr std::size_t kMinPatches = 20;

/// (mean cost of random poses about a pose − its cost) / their standard deviation; 0 when all cost
/// the same.
double z_score(const Lc2Cost& cost, const SweepPoints& sweep, const Pose& pose, int poses,
               std::uint64_t seed);

/// How to halve the pictures of a sweep.
enum class Halves { kOddEven, kFirstSecond };

/// Everything that a solve on part of the patches needs.
struct HalvesProblem {
  const CtChannels& channels;
  const PatchSet& patches;
  const SweepPoints& sweep;
  double ridge;
  int threads;
  int max_iterations;
};

/// RMS distance over the sweep of the poses that two halves of the pictures give from one start,
/// mm; infinite when a half has fewer than kMinPatches patches.
double disagreement_mm(const HalvesProblem& problem, const Pose& start, Halves halves);

}  // namespace nav::registration
