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
/// of a brick may be taken as one: a segment from lattice point k to k + m, classified between its
/// two ends like a cell.
///
/// The bound. Over a range of values, let the extinction lie in [t0, t1] per mm, and let each
/// colour channel of the visible values span at most c. Take a segment of length L whose values all
/// lie in that range. Its opacity is alpha, and its colour is a mean of colours of the range. The
/// same holds for its approximation, alpha' and colour'. With any light b in [0, 1] behind it,
///   |alpha' (colour' - b) - alpha (colour - b)| <= |alpha' - alpha| + alpha |colour' - colour|
///                                               <= L (t1 - t0) + L t1 c.
/// So no pixel differs from the exact integral along its ray by more than the sum of
/// segment_error_per_mm() · L over its segments, whatever the values do in between. Each term is
/// also weighted by the remaining light, at most 1. Shading may change a colour in any way: then
/// c = 1.
///
/// The rule. At a lattice point k that no surface, entry or exit cuts, and behind the outer surface
/// of the cutaway, the segment has m cells. m is the largest number, at least 1, that the brick of
/// k allows (brick_cells()) and for which k + m is still in that brick and not behind the end of
/// the stretch. Engines may leave a brick a little early, by rounding. A segment stays in its
/// brick, so the visible segments do not depend on leaps: images with and without leaps have the
/// same bits. Other classifications, and faded material, keep single cells.
struct AdaptiveStep {
  double error;    ///< Error of a segment in any channel in [0, 1]; > 0.
  double step_mm;  ///< Length of a cell.
  bool shaded;
  bool operator==(const AdaptiveStep&) const = default;
};

/// The largest number of cells of a segment.
inline constexpr int kMostCells = 255;

/// The adaptive step of a scene's images; none if they do not step adaptively.
std::optional<AdaptiveStep> adaptive_step(const Scene& scene, const TransferTable& table);

/// The bound above per mm, for values within [low, high] HU, widened by one entry of the table on
/// either side. Brute force over the entries.
double segment_error_per_mm(const TransferTable& table, double low_hu, double high_hu, bool shaded);

/// The number of cells that a segment may have in every brick, at least 1. Order as in BrickGrid.
/// threads 0: all cores.
std::vector<std::uint8_t> brick_cells(const BrickGrid& bricks, const TransferTable& table,
                                      const AdaptiveStep& adaptive, int threads);

}  // namespace nav::render
