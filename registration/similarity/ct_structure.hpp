// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "registration/similarity/lc2_cost.hpp"

namespace nav::registration {

/// RMS deviation of the CT within a patch at a pose, HU, of 5 x 5 points across it; infinite
/// where they are not finite, so that the solver sees the patch and says so. near: as of
/// Lc2Cost::where().
double ct_contrast_hu(const CtChannels& ct, const PatchSet& patches, std::size_t patch,
                      const GridPose& pose, PatchChannels* near = nullptr);

/// The patches that have structure of the CT under them at a pose: at least min_contrast_hu, RMS.
/// All of them where so few do that six unknowns would rest on little. What is left out cannot tell
/// poses nearby apart, but costs as much time and follows the noise of the CT. smoother: channels
/// of a coarser level, where there are any; what has next to nothing there is not looked at
/// closely.
PatchSet with_ct_structure(const CtChannels& ct, const PatchSet& patches, const Pose& pose,
                           double min_contrast_hu, PatchChannels* near = nullptr,
                           const CtChannels* smoother = nullptr);

}  // namespace nav::registration
