// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "nav/sweep.hpp"

namespace nav::registration {

/// 1 for pixels that are black in all ultrasound images and connected to the border, else 0;
/// row-major. There are no echoes around a sector, and the edge of the sector is not an echo
/// either. An enclosed black region may be a vessel, so it is 0.
std::vector<std::uint8_t> never_lit(const Sweep& sweep);

/// The sector that the ultrasound images of a sweep show, detected from its edge, because
/// recordings seldom say where their beams start. Its sides are edges of the convex hull of the lit
/// pixels, and they intersect at the apex; shadows and lost contact may hide more than half of it.
/// Empty if the lit area is not a sector about the image's depth axis: a rectangle (linear probe),
/// or sides that are inclined by more than 4 degrees. Deterministic.
std::optional<SectorOutline> sector_of(const Sweep& sweep);

/// The sweep with that sector as the outline of every image; unchanged if it already has outlines
/// or shows no sector. Pixels are shared.
Sweep with_outline(const Sweep& sweep);

}  // namespace nav::registration
