// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Leaps over empty bricks, exactly. Space: index; bricks of brick_size voxels a side.

uniform usampler3D brick_distance;  // Chebyshev distance to the nearest occupied brick, bricks.
uniform ivec3 brick_count;
uniform float brick_size;  // Voxels.

ivec3 brick_of(vec3 index) {
  return clamp(ivec3(floor(index / brick_size)), ivec3(0), brick_count - 1);
}

// Number of cells from cell k on, itself included, whose samples all lie in empty bricks; 0 when
// the sample at k does not. At distance d every brick less than d away is empty. The last cell
// leapt over is looked up the same way as it would have been sampled, and samples move
// monotonically along each axis, so no cell between can be outside either.
int empty_cells(int k, vec3 origin, vec3 direction) {
  ivec3 brick = brick_of(index_at(k, origin, direction));
  int d = int(texelFetch(brick_distance, brick, 0).r);
  if (d == 0) return 0;
  vec3 ahead = vec3(greaterThan(direction, vec3(0.0)));
  vec3 faces = (vec3(brick) + mix(vec3(1 - d), vec3(d), ahead)) * brick_size;
  // A zero component never leaves; the sign of the infinity that it would give is not needed.
  vec3 t = mix((faces - origin) / direction, vec3(1.0e30), equal(direction, vec3(0.0)));
  float t_exit = min(min(t.x, t.y), t.z);
  int last = max(k, int(floor(min(t_exit / step_mm - 0.5, 1.0e9))));
  ivec3 away = abs(brick_of(index_at(last, origin, direction)) - brick);
  if (max(max(away.x, away.y), away.z) >= d) last = max(k, last - 1);
  away = abs(brick_of(index_at(last, origin, direction)) - brick);
  return max(max(away.x, away.y), away.z) < d ? last - k + 1 : 1;
}
