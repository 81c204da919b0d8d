// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// VTK's opaque geometry. vtk_depth: window depth in [0, 1]; 1: no geometry. depth_rows: the
// elements (2,2), (2,3), (3,2), (3,3) of VTK's projection, clip_from_view.

uniform sampler2D vtk_depth;
uniform vec4 depth_rows;

// The t at which a ray meets VTK's geometry, mm; a very large number if it does not.
float t_of_geometry(ivec2 pixel, vec3 direction) {
  float depth = texelFetch(vtk_depth, pixel, 0).r;
  if (depth >= 1.0) return 3.0e38;
  float ndc = 2.0 * depth - 1.0;
  float z_view = (depth_rows.y - ndc * depth_rows.w) / (ndc * depth_rows.z - depth_rows.x);
  return -z_view / dot(direction, forward) - t_base_mm;
}
