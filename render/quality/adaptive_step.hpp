// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "render/scene.hpp"
#include "render/skipping/brick_grid.hpp"
#include "render/transfer/transfer_table.hpp"

namespace nav::render {

/// The adaptive step, for all engines. With quality.adaptive_error > 0 several pre-integrated cells
/// of a brick may be taken as one: a segment from a lattice point k to k + m, classified between
/// its two ends like a cell.
///
/// The bound. Over a range of values let the extinction lie in [t0, t1] per mm and each channel of
/// the colour of what is visible in a range of width c at most. A segment of length L whose values
/// all lie in that range has an opacity alpha and a colour that is a mean of colours of the range;
/// so has what stands for it, alpha' and colour'. With any light b in [0, 1] behind it,
///   |alpha' (colour' - b) - alpha (colour - b)| <= |alpha' - alpha| + alpha |colour' - colour|
///                                               <= L (t1 - t0) + L t1 c.
/// So no pixel differs by more than the sum of segment_error_per_mm() · L over its segments from
/// the exact integral along its rays, whatever the values do in between; each term also weighs with
/// what is left of the light, at most 1. Shading may change a colour at will: then c = 1.
///
/// The rule. At a lattice point k that no surface, entry or exit cuts, and behind the cutaway's
/// outer surface, the segment has m cells: as many as the brick of k allows (brick_cells()), of
/// which k + m is still in that brick and not behind the end of the stretch; at least 1. Engines
/// may leave a brick a little early, by rounding. Because a segment stays in its brick, which
/// segments there are where something can be seen does not depend on leaps: pictures with and
/// without them have the same bits. Other classifications, and what fades, keep single cells.
struct AdaptiveStep {
  double error;    ///< Of a segment, of any channel in [0, 1]; > 0.
  double step_mm;  ///< Of a cell.
  bool shaded;
  bool operator==(const AdaptiveStep&) const = default;
};

/// Cells of a segment, at most.
inline constexpr int kMostCells = 255;

/// Whether and how a scene's pictures step adaptively.
std::optional<AdaptiveStep> adaptive_step(const Scene& scene, const TransferTable& table);

/// The bound above per mm, for values within [low, high] HU, widened by one entry of the table
/// either side. Brute force over the entries.
double segment_error_per_mm(const TransferTable& table, double low_hu, double high_hu, bool shaded);

/// For every brick how many cells a segment may have, at least 1. Order as in BrickGrid. threads:
/// 0: all cores.
std::vector<std::uint8_t> brick_cells(const BrickGrid& bricks, const TransferTable& table,
                                      const AdaptiveStep& adaptive, int threads);

}  // namespace nav::render
