// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/scene.hpp"

namespace nav::render {

/// The volume is classified by predicates, and by no transfer function.
inline bool drawn_by_predicates(const Scene& scene) {
  return scene.predicates && scene.projection == Projection::kComposite;
}

/// Whether a picture of the scene shows a second volume.
inline bool has_two_volumes(const Scene& scene) {
  return scene.ultrasound && scene.projection == Projection::kComposite;
}

/// The scene with its ultrasound volume instead of the CT. Precondition: it has one.
Scene ultrasound_scene(const Scene& scene);

/// Thickness H of the slabs in which two volumes are composited, mm: ray_spec.hpp, "Two volumes".
/// Precondition: the scene has an ultrasound volume.
double slab_mm(const Scene& scene);

}  // namespace nav::render
