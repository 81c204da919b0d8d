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
  /// 3.37 keeps 99 % of correct pairs.
  double inlier_sigmas = 3.37;
  /// Triples of pairs that are tried; all triples if there are no more than this. >= 1.
  int max_triples = 2000;
};

/// A fit of the pairs that agree with each other.
struct RobustLandmarkRegistration {
  LandmarkRegistration fit;           ///< Fit of the agreeing pairs alone.
  std::vector<std::string> rejected;  ///< Names of the others, in the order of the pairs.
};

/// register_landmarks() that tolerates misplaced points and swapped names. It fits all triples of
/// pairs (an even choice of them beyond max_triples). The fit with the smallest truncated sum of
/// squares starts a refinement on the pairs that agree with it (Fischler and Bolles 1981; Torr and
/// Zisserman 2000). Up to 23 pairs the search is exhaustive, so nothing depends on chance. More
/// than half of the pairs must agree, and at least four if a pair is rejected, because any three
/// points nearly agree with something. Returns an error otherwise, and for everything that
/// register_landmarks() rejects; the message names the rejected pairs. Thread-safe, deterministic.
Result<RobustLandmarkRegistration> register_landmarks_robustly(
    std::span<const LandmarkPair> pairs, const RobustLandmarkOptions& options = {});

}  // namespace nav::registration
