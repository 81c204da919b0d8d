// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "render/predicate_scene.hpp"
#include "render/predicates/feature.hpp"
#include "render/predicates/place.hpp"

namespace nav::render {

/// Gradients of an ultrasound volume for predicates: central differences of the intensity at one
/// voxel, one-sided at the border, of the volume smoothed by a Gaussian; per mm along the volume's
/// axes, so that unequal spacing does not turn them.
struct GradientFeatures {
  FeatureVolume magnitude;
  /// Along and across the scan line; undefined where the scan line is. Absent without a scan.
  std::optional<FeatureVolume> along;
  std::optional<FeatureVolume> across;
};

/// smoothing_mm: sigma, >= 0, in mm; 0: none. Refuses a scan that does not fit the grid, smoothing
/// outside [0, 100] mm. Uses at most threads threads; 0: all cores. unknown: stored value of voxels
/// that no picture reached: they and their neighbours have no gradient, and nothing of them is
/// smoothed into others.
Result<GradientFeatures> make_gradient_features(const Volume& volume,
                                                const PredicateScene::IntensityWindow& intensity,
                                                const std::optional<ScanGeometry>& scan,
                                                double smoothing_mm = 0, int threads = 0,
                                                std::optional<std::int16_t> unknown = {});

/// Adds those gradients that a model asks for and that are not there yet.
Result<void> add_gradient_features(const Volume& volume, double smoothing_mm,
                                   PredicateScene& predicates, int threads = 0,
                                   std::optional<std::int16_t> unknown = {});

}  // namespace nav::render
