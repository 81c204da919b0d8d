// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "render/predicates/volume_scene.hpp"

namespace nav::bench {

/// An ultrasound volume with its features and the predicate sets that it is measured with.
struct PredicateVolume : render::PredicateVolume {
  struct Appearance {
    std::string name;
    render::PredicateModel model;
  };
  std::vector<Appearance> appearances;
};

/// The neck of sim/predicate_phantom.hpp, n voxels along each axis, with gradients, the exact
/// vesselness and labels.
Result<PredicateVolume> neck_phantom(int n);

/// A simulated patient of sim/predicate_patient.hpp with the predicate sets of Schulte zu Berge et
/// al. 2014, Figures 1 and 6 to 8; no features yet. kUsage, with the known names, for other
/// names.
Result<PredicateVolume> patient_volume(const std::string& name, int side);

/// The prostate phantom of the public data; kNotFound if it is missing.
Result<PredicateVolume> prostate_volume(Diagnostics& diagnostics);

/// Computes the features that a model reads and a volume does not have yet; vessels of 2 to 4.5 mm
/// radius.
Result<void> add_features(const render::PredicateModel& model, render::PredicateVolume& volume);

}  // namespace nav::bench
