// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nav/result.hpp"
#include "render/derived/service.hpp"
#include "render/predicate_scene.hpp"

namespace nav::render {

/// How the features that predicates read are derived from the volume.
struct DerivedFeatureOptions {
  derived::SnrOptions snr;
  derived::VesselnessOptions vesselness;
  derived::ConfidenceOptions confidence;
};

/// Adds signal-to-noise ratio, vesselness and confidence where a predicate of the model asks for
/// them and they are not there yet; computes nothing else. They are asked for all at once; waits
/// for them. Refuses confidence without scan lines, or with a direction per voxel but no feature
/// depth, and whatever the features themselves do.
Result<void> add_derived_features(const std::shared_ptr<const Volume>& volume,
                                  const DerivedFeatureOptions& options,
                                  derived::DerivedVolumes& service, PredicateScene& predicates);

}  // namespace nav::render
