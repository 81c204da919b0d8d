// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/scene.hpp"

namespace nav::render {

/// True if predicates classify the volume instead of the transfer function.
inline bool drawn_by_predicates(const Scene& scene) {
  return scene.predicates && scene.projection == Projection::kComposite;
}

/// True if an image of the scene shows a second volume.
inline bool has_two_volumes(const Scene& scene) {
  return scene.ultrasound && scene.projection == Projection::kComposite;
}

/// The scene with its ultrasound volume in place of the CT. Precondition: it has one.
Scene ultrasound_scene(const Scene& scene);

/// Thickness H of the slabs in which two volumes are composited, mm: ray_spec.hpp, "Two volumes".
/// Precondition: the scene has an ultrasound volume.
double slab_mm(const Scene& scene);

}  // namespace nav::render
