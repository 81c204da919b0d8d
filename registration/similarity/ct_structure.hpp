// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "registration/similarity/similarity_cost.hpp"

namespace nav::registration {

/// RMS deviation of the CT within a patch at a pose, HU, at 5 x 5 points across it. Infinite if the
/// points are not finite, so that the solver evaluates the patch and reports it. near: see
/// SimilarityCost::where().
double ct_contrast_hu(const CtChannels& ct, const PatchSet& patches, std::size_t patch,
                      const GridPose& pose, PatchChannels* near = nullptr);

/// The patches that contain CT structure at a pose: at least min_contrast_hu, RMS. Returns all
/// patches if so few do that they would not determine six unknowns reliably. Patches without
/// structure cannot distinguish nearby poses, but cost as much time and follow the noise of the CT.
/// smoother: channels of a coarser level, if there are any; patches with next to no contrast there
/// are not evaluated further.
PatchSet with_ct_structure(const CtChannels& ct, const PatchSet& patches, const Pose& pose,
                           double min_contrast_hu, PatchChannels* near = nullptr,
                           const CtChannels* smoother = nullptr);

}  // namespace nav::registration
