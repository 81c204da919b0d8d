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
  int starts = 0;           ///< Seeded starts of a batch in the box about the initial pose, >= 0.
  double range_mm = 0;      ///< Half width of the box of translations.
  double range_rad = 0;     ///< Half width of the box of rotation vectors.
  int max_iterations = 30;  ///< Of a solve.
  std::uint64_t seed = 1;
  int threads = 1;  ///< 1 to 64; the result does not depend on it.
};

/// A pose that the search ended in.
struct Found {
  PoseSolution solution;  ///< Costs on all patches.
  bool plain;             ///< From the initial pose.
};

/// The plain solve from the initial pose, and unless that is clearly right already, a search: the
/// starts are ranked by a few samples of each patch, the best are tried for a few steps, the best
/// of these solved, and the surroundings of the best results are searched again, narrower each
/// time; all that up to three times with other starts, until a result is clearly right. Clearly
/// right: its cost lies seven standard deviations below those of the random starts. Best first; at
/// least the plain one.
/// non_finite grows to the most patches of an evaluation that were not finite.
std::vector<Found> search(const Lc2Cost& cost, const Pose& initial, const SweepPoints& points,
                          const SearchOptions& options, const std::function<bool()>& keep_going,
                          int& non_finite);

/// Poses to be searched among.
struct Places {
  const std::vector<Pose>& poses;
  double spacing_mm;  ///< They lie about so far apart, > 0.
  /// So many of the cheapest are tried for a few steps, >= 1: the nearest to the right one need
  /// not be among the very cheapest.
  std::size_t tried;
};

/// The same among given poses instead of seeded starts about one: ranked, tried, searched about.
/// Each round spends more on fewer of them (successive halving). Best first; empty where there are
/// none.
std::vector<Found> search_among(const Lc2Cost& cost, const Places& places,
                                const SweepPoints& points, const SearchOptions& options,
                                const std::function<bool()>& keep_going, int& non_finite);

}  // namespace nav::registration
