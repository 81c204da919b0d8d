// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "registration/twist.hpp"

namespace nav::registration {

/// A motion of the pose that the data do not show.
struct SlidingDirection {
  Vector6d twist;           ///< Unit: [rotation rad | translation mm] about the given centre, Ct.
  std::string description;  ///< "translation along Ct (…)", "rotation about Ct (…) through (…) mm".
};

/// Eigenvalues and eigenvectors of the curvature in parameters [lever·ω | t], mm.
struct Observability {
  Vector6d strengths;   ///< Ascending: squared change of the residuals per squared mm of motion.
  Matrix6d directions;  ///< Columns, orthonormal, in scaled parameters.
  double lever_mm;      ///< Scale of the rotations.
  int unseen;           ///< Number of strengths below the least that counts.

  [[nodiscard]] Vector6d twist(Eigen::Index column) const;
};

/// Analyses the curvature by a twist [rad | mm]; lever_mm > 0. least: strength from which a
/// direction counts as seen.
Observability observability(const Matrix6d& curvature, double lever_mm, double least);

/// Descriptions of the unseen directions: first the pure translations among their combinations,
/// then rotations, each about its own axis; free translations are removed from the rotations.
/// centre_ct_mm: centre of the twists.
std::vector<SlidingDirection> sliding_directions(const Observability& seen,
                                                 const Eigen::Vector3d& centre_ct_mm);

}  // namespace nav::registration
