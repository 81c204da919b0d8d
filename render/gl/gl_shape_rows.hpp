// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/scene.hpp"
#include "render/spec/ray_spec.hpp"

namespace nav::render {

/// Texels of four numbers, row by row, as a texture of shapes holds them. Internal to render/.
struct GlRows {
  int width = 0;  ///< In texels.
  int height = 0;
  std::vector<float> texels;
  bool operator==(const GlRows&) const = default;
};

/// Rows of needle, spheres and lines, in this order: (a, radius), (b, 0), (rgb, alpha); local mm.
GlRows solid_rows(const Scene& scene);
/// True if one of them is longer than a sphere.
bool has_capsules(const Scene& scene);

/// Rows of the objects that cut: normal and number of vertices (0: a ball), two axes of the plane,
/// a ball around the object, then the vertices; local mm. See shaders/include/cutaway.glsl.
GlRows cut_rows(const spec::CutawayObjects<double>& objects);

}  // namespace nav::render
