// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/scene.hpp"
#include "render/spec/ray_spec.hpp"

namespace nav::render {

/// Texels of four numbers, row after row, as a texture of shapes holds them. Internal to render/.
struct GlRows {
  int width = 0;  ///< Texels.
  int height = 0;
  std::vector<float> texels;
  bool operator==(const GlRows&) const = default;
};

/// Needle, spheres and lines in their order, each (a, radius), (b, 0), (rgb, alpha); local mm.
GlRows solid_rows(const Scene& scene);
/// Whether one of them is longer than a sphere.
bool has_capsules(const Scene& scene);

/// What cuts: normal and number of vertices (0: a ball), two axes of the plane, a ball around it,
/// then the vertices; local mm. See shaders/include/cutaway.glsl.
GlRows cut_rows(const spec::CutawayObjects<double>& objects);

}  // namespace nav::render
