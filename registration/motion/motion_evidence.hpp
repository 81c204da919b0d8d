// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "registration/image_registration.hpp"
#include "registration/similarity/ct_channels.hpp"
#include "registration/similarity/patches.hpp"

namespace nav::registration {

/// Input of a refinement by motion or deformation: one level of patches and the CT near them.
struct MotionEvidence {
  CtChannels ct;
  PatchSet patches;
};

/// Level that a deformation is fitted to: many patches, spread evenly. Patches of highest contrast
/// deformed patients who lay still by up to 9 mm, and images that were left out of the fit agreed.
inline constexpr LevelOptions kMotionLevel{.sample_step_mm = 1.2,
                                           .patch_side = 9,
                                           .patches = 5000,
                                           .frame_step_mm = 1.5,
                                           .choice = PatchChoice::kEven};

/// A pose farther than this from the pose that a motion or deformation was fitted about is another
/// minimum.
inline constexpr double kMaxSettlingMm = 3;

/// Patches of one level. If the level chooses patches evenly, only those in which the CT has
/// structure at the pose are kept. Errors: those of shadow_masks() and make_ct_channels().
Result<MotionEvidence> motion_evidence(const Volume& ct, const Sweep& sweep,
                                       const Transform<frames::Ct, frames::Reference>& pose,
                                       const ShadowMaskOptions& mask,
                                       const LevelOptions& level = kMotionLevel);

/// motion_evidence() for several levels; the masks are computed once.
Result<std::vector<MotionEvidence>> motion_evidence(
    const Volume& ct, const Sweep& sweep, const Transform<frames::Ct, frames::Reference>& pose,
    const ShadowMaskOptions& mask, std::span<const LevelOptions> levels);

}  // namespace nav::registration
