// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The bricks of the volume, and the cells at which rays leave them.

uniform usampler3D bricks;  // Data of each brick; its layout depends on the program.
uniform ivec3 brick_count;
uniform float bricks_per_voxel;
uniform float brick_margin;  // More than the rounding of an index, in voxels.

#ifdef PREINTEGRATED
const float kPlace = 0.0;  // Position of a sample in its cell.
#else
const float kPlace = 0.5;
#endif

ivec3 last_brick;  // This and the next three are copies: taken_over.glsl.
float bricks_a_voxel;
float voxels_a_brick;
float rounding;
vec3 cells_a_voxel;  // Along each axis; 1e30 if the ray does not move along it.

void take_over_bricks() {
  last_brick = brick_count - 1;
  bricks_a_voxel = taken_over(bricks_per_voxel);
  voxels_a_brick = 1.0 / bricks_per_voxel;
  rounding = taken_over(brick_margin);
  cells_a_voxel = 1.0 / lattice_step;
}

ivec3 brick_of(int n) {
  vec3 index = index_at(float(n) + kPlace);
  return clamp(ivec3(floor(index * bricks_a_voxel)), ivec3(0), last_brick);
}

// The cell at which a ray leaves a box. low, high: in bricks. margin: enlarges the box, in voxels.
float leaves_box(vec3 low, vec3 high, float margin) {
  bvec3 ahead = greaterThan(lattice_step, vec3(0.0));
  vec3 faces = mix(low, high, ahead) * voxels_a_brick + mix(vec3(-margin), vec3(margin), ahead);
  vec3 exits = mix((faces - lattice_origin) * cells_a_voxel, vec3(1.0e9),
                   equal(lattice_step, vec3(0.0)));
  return clamp(min(min(exits.x, exits.y), exits.z), -1.0e9, 1.0e9) - kPlace;
}

// The cell at which a ray leaves the cube of all bricks that are less than reach away from a brick.
float leaves_cube(ivec3 brick, int reach, float margin) {
  return leaves_box(vec3(brick + 1 - reach), vec3(brick + reach), margin);
}
