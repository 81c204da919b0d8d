// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "registration/landmarks/landmarks.hpp"

namespace nav::registration {

struct RobustLandmarkOptions {
  /// A pair farther than this from the fit, in its own sigmas (3D distance), is an outlier; > 0.
  /// 3.37 keeps 99 % of honest pairs.
  double inlier_sigmas = 3.37;
  int max_triples = 2000;  ///< Triples of pairs tried; all of them where there are no more. >= 1.
};

/// A fit of the pairs that agree.
struct RobustLandmarkRegistration {
  LandmarkRegistration fit;           ///< Of the agreeing pairs alone.
  std::vector<std::string> rejected;  ///< Names of the others, in the order of the pairs.
};

/// register_landmarks() that withstands misplaced points and swapped names: of the fits of all
/// triples of pairs (an even choice of them beyond max_triples) the one with the smallest truncated
/// sum of squares starts a refinement on the pairs that agree with it (Fischler and Bolles 1981;
/// Torr and Zisserman 2000). Up to 23 pairs this is exhaustive: nothing depends on luck. What
/// agrees must be more than half of the pairs, and at least four when one is rejected: any three
/// points nearly agree with something. Refuses otherwise, and everything that register_landmarks()
/// refuses; the message names the rejected pairs. Thread-safe, deterministic.
Result<RobustLandmarkRegistration> register_landmarks_robustly(
    std::span<const LandmarkPair> pairs, const RobustLandmarkOptions& options = {});

}  // namespace nav::registration
