// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/two_volumes.hpp"

#include <algorithm>

#include "render/spec/ray_spec_volume.hpp"

namespace nav::render {

Scene ultrasound_scene(const Scene& scene) {
  Scene out = scene;
  out.ct = scene.ultrasound->volume;
  out.predicates = scene.ultrasound->predicates;
  out.ultrasound.reset();
  out.gradient_source.reset();
  return out;
}

double slab_mm(const Scene& scene) {
  return std::max(spec::step_mm(scene.quality, scene.ct->grid()),
                  spec::step_mm(scene.quality, scene.ultrasound->volume->grid()));
}

}  // namespace nav::render
