// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The global lattice of cells. A position in cells is the ray parameter in units of a cell, so cell
// k covers [k, k + 1): cells = t / step_mm - shift.

uniform float step_mm;  // Length of a cell.

vec3 lattice_origin;  // Index at position 0, in cells.
vec3 lattice_step;    // Index per cell.
vec3 ray_direction;   // Unit, local mm.
vec4 cost;            // CT samples, shaded samples, faded cells; 1, or 2 if the ray is cut.
float lattice_shift;  // Part of a cell, [0, 1).

#ifdef JITTER
uniform float image_height;  // In pixels.

// The integer hash of spec::jitter_of; row 0 at the top.
float jitter_of(ivec2 pixel) {
  uint h = uint(pixel.x) * 0x8da6b343u + uint(pixel.y) * 0xd8163841u;
  h = (h ^ (h >> 16)) * 0x7feb352du;
  h = (h ^ (h >> 15)) * 0x846ca68bu;
  return float((h ^ (h >> 16)) >> 8) / 16777216.0;
}
#endif

float cell_mm;        // A copy of step_mm: taken_over.glsl.

void set_lattice(Ray ray) {
  take_over_volume();
  cell_mm = taken_over(step_mm);
#ifdef JITTER
  ivec2 pixel = ivec2(fragment_centre);
  lattice_shift = jitter_of(ivec2(pixel.x, int(image_height) - 1 - pixel.y));
#else
  lattice_shift = 0.0;
#endif
  ray_direction = ray.direction;
  lattice_step = index_from_local * ray.direction * step_mm;
  lattice_origin = index_from_local * ray.origin + lattice_shift * lattice_step;
  cost = vec4(0.0, 0.0, 0.0, 1.0);
}

float cells_of(float t) { return t / cell_mm - lattice_shift; }
float t_of(float cells) { return (cells + lattice_shift) * cell_mm; }

// precise: every caller gets the same bits for a position.
vec3 index_at(float cells) {
  precise vec3 index = fma(vec3(cells), lattice_step, lattice_origin);
  return index;
}

float value_at(float cells) {
  cost.x += 1.0;
  return ct_hu(index_at(cells));
}
