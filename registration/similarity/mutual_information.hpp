// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "registration/similarity/similarity_cost.hpp"

namespace nav::registration {

/// 1 − I(U; F)/H(U) of the greys U of all samples and the CT values F at their positions, [0, 1]; 1
/// if the ultrasound images have a single grey. It uses 24 bins of grey and 24 bins of the CT with
/// a cubic B-spline window (Mattes et al. 2003), so that the cost is smooth in the pose; H(U) does
/// not depend on the pose. Patches that are not finite are ignored. One thread.
CostTerms mutual_information(const CtChannels& ct, const PatchSet& patches,
                             const Pose& ct_from_reference);

/// mutual_information() with the derivatives of half of it by a twist about a centre. The gradient
/// is exact; the Hessian is Σ dp dpᵀ (1/p − 1/p_F), positive semi-definite (Thévenaz and Unser
/// 2000, eq. 25).
CostTerms mutual_information_terms(const CtChannels& ct, const PatchSet& patches,
                                   const Pose& ct_from_reference,
                                   const Eigen::Vector3d& centre_ct_mm, bool keep_patch_gradients);

}  // namespace nav::registration
