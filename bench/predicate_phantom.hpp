// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "render/predicates/predicate_scene.hpp"
#include "render/scene.hpp"

namespace nav::bench {

/// An ultrasound volume with its features and predicate sets.
struct PredicateVolume {
  std::string name;
  std::shared_ptr<const Volume> ultrasound;
  render::PredicateScene predicates;  ///< Features, scan and window; no model.
  struct Look {
    std::string name;
    render::PredicateModel model;
  };
  std::vector<Look> looks;
};

/// A neck, 40 mm a side in n voxels: skin, muscle and a forked vessel below it, with Rayleigh
/// speckle and attenuation, scanned by parallel lines along +y. It has gradients, the exact
/// distance to the vessel's axis as vesselness, and layers as labels. Stored values 0 to 255.
Result<PredicateVolume> neck_phantom(int n);

/// neck_phantom() without gradients and vesselness.
Result<PredicateVolume> neck_volume(int n);

/// The prostate phantom of the public data; kNotFound if it is missing.
Result<PredicateVolume> prostate_volume(Diagnostics& diagnostics);

/// The scene of a predicate set: seen from the probe's side and a little from the left.
render::Scene predicate_scene(const PredicateVolume& volume, const PredicateVolume::Look& look,
                              int width, int height);

/// The volume of by_predicates with a grey transfer function of the same opacities: standard
/// rendering.
render::Scene standard_scene(const render::Scene& by_predicates);

}  // namespace nav::bench
