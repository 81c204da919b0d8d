// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "render/predicates/predicate_scene.hpp"
#include "render/scene.hpp"

namespace nav::render {

/// An ultrasound volume that predicates can draw.
struct PredicateVolume {
  std::string name;
  std::shared_ptr<const StoredVolume> ultrasound;
  PredicateScene predicates;  ///< Features, scan and window. Its model is for the caller to set.
};

/// Returns the scene of a volume drawn by the model, seen from the probe's side and a little from
/// the left. width and height: pixels.
Scene predicate_scene(const PredicateVolume& volume, const PredicateModel& model, int width,
                      int height);

/// Returns the same scene drawn by a grey transfer function of the same opacities: standard
/// rendering. Precondition: the scene has predicates.
Scene standard_scene(const Scene& by_predicates);

}  // namespace nav::render
