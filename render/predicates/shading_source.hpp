// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nav/result.hpp"
#include "nav/volume.hpp"
#include "render/predicates/predicate_scene.hpp"

namespace nav::render {

/// Intensity gradient from which samples by predicates are fully shaded, fractions of white per mm.
/// Of the smoothed speckle of tissue a fifth or less lies above it.
inline constexpr double kUsualFullGradientPerMm = 0.1;

/// The shading of a volume by its intensities, from black to white, smoothed by a Gaussian of
/// smoothing_mm: smoothed_for_gradients() with 16000 steps from black to white, so that rounding
/// turns no normal. full_gradient_per_mm: fractions of white per mm. The bytes do not depend on the
/// number of threads (0: all cores). kUsage for a smoothing outside (0, kMostSmoothingMm] and a
/// full gradient outside [1e-4, 100].
Result<PredicateShading> shading_of_predicates(const StoredVolume& volume,
                                               const PredicateScene::IntensityWindow& window,
                                               double smoothing_mm, double full_gradient_per_mm,
                                               int threads);

}  // namespace nav::render
