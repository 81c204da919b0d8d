// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"
#include "render/predicates/volume_scene.hpp"

namespace nav::render {

/// Gives a volume the intensities by which floors and soft thresholds draw, and leaves the
/// intensities that predicates test as they are (a feature `intensity`). Engines draw the result as
/// any other volume, so that their bounds of early termination hold unchanged. Does nothing without
/// a floor and with soft_share = 0.
///
/// Soft thresholds. For a predicate with a range of one feature, low to high, and the ramps
/// a = soft_share · |low| and b = soft_share · |high|, the soft truth of a value v is
///   min(clamp((v - low + a) / a), clamp((high + b - v) / b)) in [0, 1];
/// other predicates have 0 or 1; `not` is 1 - x, `all` the least, `any` the greatest. Ranges become
/// wider by their ramps (those under a `not` do not), so that a predicate is true exactly where its
/// soft truth exceeds 0. The intensity of a voxel is multiplied by the greatest soft truth of the
/// predicates with importance above 0.
/// Floors. Where predicates are true, before they were widened, the intensity is at least the
/// greatest of their floors.
///
/// Both act on voxels; between voxels values are interpolated as always. Deterministic. Errors:
/// kUsage when predicates that matter read the needle or the target, which move; soft_share outside
/// [0, 1]. Precondition: a model whose `connected` were resolved.
Result<void> shape_intensity(PredicateVolume& volume, double soft_share);

}  // namespace nav::render
