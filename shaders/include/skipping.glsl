// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Leaps over bricks where nothing can be seen, exactly: a cell is leapt over only when every place
// that it samples lies in such a brick. For the two ends of a pre-integrated cell that is enough:
// bricks that touch share voxels, so their ranges of values overlap, and the values between the
// ends are in one range or the other. (Steps are at most a brick long where this is compiled.)

// Distance to the nearest occupied brick, in bricks along the longest axis; greatest importance.
uniform usampler3D bricks;
uniform ivec3 brick_count;
uniform float bricks_per_voxel;
uniform float brick_margin;  // More than the rounding of an index, voxels.

#ifdef PREINTEGRATED
const float kPlace = 0.0;  // Of a sample in its cell.
#else
const float kPlace = 0.5;
#endif

// In an occupied brick a ray looks again after this many samples, wherever it leaves the brick: rays
// that run in step would wait for the one that leaves last, and may as well sample.
const int kRun = 8;

// What a ray meets at one of its samples.
struct Brick {
  bool empty;  // Nothing can be seen here.
  int until;   // Empty: the last sample that is surely so. Else the first one to look at again.
};

ivec3 brick_of(int n) {
  vec3 index = index_at(float(n) + kPlace);
  return clamp(ivec3(floor(index * bricks_per_voxel)), ivec3(0), brick_count - 1);
}

// Where a ray leaves the cube of bricks less than reach away from one; margin: voxels farther out.
float leaves_cube(ivec3 brick, int reach, float margin) {
  bvec3 ahead = greaterThan(lattice_step, vec3(0.0));
  vec3 faces = (vec3(brick) + mix(vec3(1 - reach), vec3(reach), ahead)) / bricks_per_voxel +
               mix(vec3(-margin), vec3(margin), ahead);
  vec3 exits = mix((faces - lattice_origin) / lattice_step, vec3(1.0e9),
                   equal(lattice_step, vec3(0.0)));
  return clamp(min(min(exits.x, exits.y), exits.z), -1.0e9, 1.0e9) - kPlace;
}

Brick brick_at(int n) {
  ivec3 at = brick_of(n);
  uvec2 known = texelFetch(bricks, at, 0).rg;
  bool empty = known.r > 0u;
  // An empty region is left a little early.
  int inside = int(floor(leaves_cube(at, int(known.r), -brick_margin)));
  return Brick(empty, empty ? max(inside, n) : n + kRun);
}

#ifdef CUTAWAY
// The same in the part of a ray that fades: what is occupied counts as empty where its greatest
// importance cannot be visible yet. A cell is leapt over when it ends before that place.
Brick fading_brick_at(int n) {
  ivec3 at = brick_of(n);
  uvec2 known = texelFetch(bricks, at, 0).rg;
  bool empty = known.r > 0u;
  float leaves = leaves_cube(at, int(max(known.r, 1u)), empty ? -brick_margin : brick_margin);
  int inside = max(int(floor(leaves)), n);
  if (empty) return Brick(true, inside);
  float until = cells_of(hidden_until(cut_span, float(known.g) / 254.0));
  int hidden = int(floor(clamp(until, -1.0e9, 1.0e9))) - 1;
  if (known.g == 255u || hidden < n) return Brick(false, n + kRun);
  return Brick(true, min(hidden, max(n, inside - 1)));
}
#endif
