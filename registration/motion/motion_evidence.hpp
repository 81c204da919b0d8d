// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "registration/image_registration.hpp"
#include "registration/similarity/ct_channels.hpp"
#include "registration/similarity/patches.hpp"

namespace nav::registration {

/// What a refinement by motion or deformation looks at: one level of patches and the CT near them.
struct MotionEvidence {
  CtChannels ct;
  PatchSet patches;
};

/// What a deformation is fitted to: many patches, spread evenly. Those of most contrast bent
/// patients who lay still by up to 9 mm, and pictures that were left out agreed.
inline constexpr LevelOptions kMotionLevel{1.2, 9, 5000, 1.5, PatchChoice::kEven};

/// Farther from the pose that a motion or deformation was fitted about it is another minimum.
inline constexpr double kMaxSettlingMm = 3;

/// Patches of one level, those where the CT has structure at the pose where the level chooses
/// evenly. Errors: those of shadow_masks() and make_ct_channels().
Result<MotionEvidence> motion_evidence(const Volume& ct, const Sweep& sweep,
                                       const Transform<frames::Ct, frames::Reference>& pose,
                                       const ShadowMaskOptions& mask,
                                       const LevelOptions& level = kMotionLevel);

/// The same of several levels, masked once.
Result<std::vector<MotionEvidence>> motion_evidence(
    const Volume& ct, const Sweep& sweep, const Transform<frames::Ct, frames::Reference>& pose,
    const ShadowMaskOptions& mask, std::span<const LevelOptions> levels);

}  // namespace nav::registration
