// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "registration/pose_solver.hpp"
#include "registration/similarity/sweep_points.hpp"

namespace nav::registration {

struct SearchOptions {
  int starts = 0;           ///< Seeded starts of one batch in the box about the initial pose, >= 0.
  double range_mm = 0;      ///< Half width of the box of translations.
  double range_rad = 0;     ///< Half width of the box of rotation vectors.
  int max_iterations = 30;  ///< Limit for each solve.
  std::uint64_t seed = 1;
  int threads = 1;  ///< 1 to 64; the result does not depend on it.
};

/// A pose in which the search ended.
struct Found {
  PoseSolution solution;  ///< cost fields are those of all patches.
  bool plain;             ///< True if solved from the initial pose.
};

/// Solves from the initial pose (the plain solve) and, unless that result is clearly right,
/// searches globally. The search ranks the starts by a few samples of each patch, tries the best
/// for a few steps, solves the best of these, and searches around the best results again, narrower
/// each time. It does all that up to three times with other starts, until a result is clearly
/// right: its cost lies seven standard deviations below the costs of the random starts. The results
/// are sorted, best first; they contain at least the plain one. non_finite is raised to the largest
/// number of non-finite patches in one evaluation.
std::vector<Found> search(const SimilarityCost& cost, const Pose& initial,
                          const SweepPoints& points, const SearchOptions& options,
                          const std::function<bool()>& keep_going, int& non_finite);

/// Poses among which to search.
struct Places {
  const std::vector<Pose>& poses;
  double spacing_mm;  ///< Approximate distance of neighbouring poses, > 0.
  /// Number of the cheapest poses that are tried for a few steps, >= 1: the poses nearest to the
  /// right one need not be among the very cheapest.
  std::size_t tried;
};

/// search() among given poses instead of seeded starts about one pose: it ranks them, tries the
/// best and searches around them. Each round spends more time on fewer poses (successive halving).
/// Best first; empty if there are no poses.
std::vector<Found> search_among(const SimilarityCost& cost, const Places& places,
                                const SweepPoints& points, const SearchOptions& options,
                                const std::function<bool()>& keep_going, int& non_finite);

}  // namespace nav::registration
