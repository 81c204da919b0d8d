// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "registration/twist.hpp"

namespace nav::registration {

/// A motion of the pose that the data do not see.
struct SlidingDirection {
  Vector6d twist;           ///< Unit: [rotation rad | translation mm] about the centre given, Ct.
  std::string description;  ///< "translation along Ct (…)", "rotation about Ct (…) through (…) mm".
};

/// Eigenvalues and eigenvectors of the curvature in parameters [lever·ω | t], mm.
struct Observability {
  Vector6d strengths;   ///< Ascending: squared residual change per squared mm moved.
  Matrix6d directions;  ///< Columns, orthonormal, in scaled parameters.
  double lever_mm;      ///< Scales rotations.
  int unseen;           ///< How many strengths lie below the least that counts.

  [[nodiscard]] Vector6d twist(Eigen::Index column) const;
};

/// Takes the curvature by a twist [rad | mm] apart; lever_mm > 0. least: strength from which on a
/// direction counts as seen.
Observability observability(const Matrix6d& curvature, double lever_mm, double least);

/// Names of the unseen directions: first the pure translations among their combinations, then
/// rotations (with what translation goes with them left out), each about the axis that they have.
/// centre_ct_mm: about which the twists turn.
std::vector<SlidingDirection> sliding_directions(const Observability& seen,
                                                 const Eigen::Vector3d& centre_ct_mm);

}  // namespace nav::registration
