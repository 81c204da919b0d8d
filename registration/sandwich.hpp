// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "registration/lc2_cost.hpp"
#include "registration/pose_uncertainty.hpp"

namespace nav::registration {

/// Covariance of an image registration, or why there is none.
struct SandwichCovariance {
  PoseUncertainty uncertainty;
  bool valid;
  std::string fault;  ///< One sentence that names the direction; empty when valid.
};

/// Σ = H⁻¹ (n/(n−6) Σ_b g_b g_bᵀ) H⁻¹ about a centre, at a minimum of the cost. H is the true
/// Hessian, by symmetric differences of the exact gradient over step_mm: Gauss–Newton's is too
/// stiff, as each patch also fits its noise. g_b sums the gradients of all patches in one 20 mm
/// cube of the CT: pictures that see the same anatomy err together. bias_floor_mm² is added to the
/// translations and, over 60 mm, to the rotations. (White 1980; Liang and Zeger 1986.)
SandwichCovariance sandwich_covariance(const Lc2Cost& cost, const Pose& pose,
                                       const Point<frames::Ct>& centre_ct, double step_mm,
                                       double bias_floor_mm);

}  // namespace nav::registration
