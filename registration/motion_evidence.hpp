// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "registration/ct_channels.hpp"
#include "registration/image_registration.hpp"
#include "registration/patches.hpp"

namespace nav::registration {

/// What a refinement by motion or deformation looks at: one level of patches and the CT near them.
struct MotionEvidence {
  CtChannels ct;
  PatchSet patches;
};

/// Both motions are smooth and have many unknowns: a middle level with many patches.
inline constexpr LevelOptions kMotionLevel{1.6, 9, 1500, 1.0};

/// Errors: those of shadow_masks() and make_ct_channels().
Result<MotionEvidence> motion_evidence(const Volume& ct, const Sweep& sweep,
                                       const Transform<frames::Ct, frames::Reference>& pose,
                                       const ShadowMaskOptions& mask,
                                       const LevelOptions& level = kMotionLevel);

}  // namespace nav::registration
