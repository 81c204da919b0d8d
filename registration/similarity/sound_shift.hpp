// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nav/transform.hpp"
#include "registration/similarity/ct_channels.hpp"
#include "registration/similarity/patches.hpp"

/// Speed of sound from CT: scanners assume 1540 m/s, and fat is slower by 7 %, muscle and liver are
/// faster by 2 to 3 %. At 100 mm depth that is 1 to 3 mm.
namespace nav::registration {

/// Speed of sound at a CT value, m/s. Density by Schneider et al. 1996 (Phys. Med. Biol. 41), and
/// speed by density by Mast 2000 (ARLO 1), between fat (-100 HU) and unenhanced organs (55 HU):
/// contrast agent changes HU, not the speed.
double sound_speed_at(double hu);

/// Distance along the beam, mm, by which each patch is shown deeper than it lies (negative: less
/// deep), if the speed of sound is what the CT says along its beam. By Patch::index; 0 for indices
/// without a patch. Gel, air, gas and bone count as 1540 m/s. \p ct: HU channels. O(patches ·
/// depth).
std::vector<float> sound_shifts_mm(const CtChannels& ct, const PatchSet& patches,
                                   const Transform<frames::Ct, frames::Reference>& pose);

}  // namespace nav::registration
