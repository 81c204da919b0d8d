// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::render {

/// Greatest smoothing of a gradient source, mm.
inline constexpr double kMostSmoothingMm = 20;

/// A volume smoothed by a Gaussian of sigma_mm along every axis, as a Scene::gradient_source:
/// gradients where edges of the data are sharper than a voxel then turn slowly, so that surfaces
/// show no terraces. The Gaussian ends at three sigmas, its weights sum to 1, and the border is
/// repeated. Values are rounded. 0 returns the volume itself. The bytes do not depend on the number
/// of threads (0: all cores). kUsage for a sigma outside [0, kMostSmoothingMm].
Result<std::shared_ptr<const StoredVolume>> smoothed_for_gradients(
    const std::shared_ptr<const StoredVolume>& volume, double sigma_mm, int threads);

}  // namespace nav::render
