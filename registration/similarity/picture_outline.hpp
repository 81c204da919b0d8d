// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "nav/sweep.hpp"

namespace nav::registration {

/// 1 where none of the pictures ever shows anything, as far as that is connected to the border;
/// row-major. Around a sector there is no echo, and its edge is none either. Black that is enclosed
/// may be a vessel.
std::vector<std::uint8_t> never_lit(const Sweep& sweep);

/// The sector that the pictures of a sweep show, from its edge: recordings seldom say where their
/// beams start. Its sides are edges of the convex hull of what is lit, their crossing is the apex;
/// shadows and lost contact may take more than half of it. Nothing where what is lit is no sector
/// about the picture's depth axis: a rectangle (linear probe), or sides that lean by more than 4
/// degrees. Deterministic.
std::optional<SectorOutline> sector_of(const Sweep& sweep);

/// The sweep with that sector on every picture; as it came where it has outlines or shows no
/// sector. Pixels are shared.
Sweep with_outline(const Sweep& sweep);

}  // namespace nav::registration
