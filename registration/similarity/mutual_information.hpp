// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "registration/similarity/lc2_cost.hpp"

namespace nav::registration {

/// 1 − I(U; F)/H(U) of the greys U of all samples and the CT F where they lie, [0, 1]; 1 where the
/// pictures have one grey only. 24 bins of grey, 24 of the CT with a cubic B-spline window (Mattes
/// et al. 2003), so that the cost is smooth in the pose; H(U) does not depend on it. A patch that
/// is not finite counts as not there. One thread.
CostTerms mutual_information(const CtChannels& ct, const PatchSet& patches,
                             const Pose& ct_from_reference);

/// With the derivatives of half of it by a twist about a centre: the gradient exact, the Hessian
/// Σ dp dpᵀ (1/p − 1/p_F), positive semi-definite (Thévenaz and Unser 2000, eq. 25).
CostTerms mutual_information_terms(const CtChannels& ct, const PatchSet& patches,
                                   const Pose& ct_from_reference,
                                   const Eigen::Vector3d& centre_ct_mm, bool keep_patch_gradients);

}  // namespace nav::registration
