// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Leaps over bricks where nothing can be seen, exactly: a cell is leapt over only when every place
// that it samples lies in such a brick. For the two ends of a pre-integrated cell that is enough:
// bricks that touch share voxels, so their ranges of values overlap, and the values between the
// ends are in one range or the other. (Steps are at most a brick long where this is compiled.)

uniform usampler3D bricks;  // Chebyshev distance to the nearest occupied brick; greatest importance.
uniform ivec3 brick_count;
uniform float bricks_per_voxel;
uniform float brick_margin;  // More than the rounding of an index, voxels.

#ifdef PREINTEGRATED
const float kPlace = 0.0;  // Of a sample in its cell.
#else
const float kPlace = 0.5;
#endif

// What a ray meets at one of its samples.
struct Brick {
  bool empty;  // Nothing can be seen here.
  int until;   // Empty: the last sample that is surely so. Else the first one surely outside.
};

Brick brick_at(int n) {
  vec3 index = index_at(float(n) + kPlace);
  ivec3 at = clamp(ivec3(floor(index * bricks_per_voxel)), ivec3(0), brick_count - 1);
  int d = int(texelFetch(bricks, at, 0).r);
  bvec3 ahead = greaterThan(lattice_step, vec3(0.0));
  int reach = max(d, 1);
  // An empty brick is left before the face of its cube, an occupied one behind its own.
  float margin = d > 0 ? -brick_margin : brick_margin;
  vec3 faces = (vec3(at) + mix(vec3(1 - reach), vec3(reach), ahead)) / bricks_per_voxel +
               mix(vec3(-margin), vec3(margin), ahead);
  vec3 exits = mix((faces - lattice_origin) / lattice_step, vec3(1.0e9),
                   equal(lattice_step, vec3(0.0)));
  float leaves = clamp(min(min(exits.x, exits.y), exits.z), -1.0e9, 1.0e9) - kPlace;
  int inside = int(floor(leaves));
  return Brick(d > 0, d > 0 ? max(inside, n) : max(inside, n) + 1);
}

#ifdef CUTAWAY
// The same in the part of a ray that fades: what is occupied counts as empty where its greatest
// importance cannot be visible yet. A cell is leapt over when it ends before that place.
Brick fading_brick_at(int n) {
  Brick brick = brick_at(n);
  vec3 index = index_at(float(n) + kPlace);
  ivec3 at = clamp(ivec3(floor(index * bricks_per_voxel)), ivec3(0), brick_count - 1);
  int code = int(texelFetch(bricks, at, 0).g);
  if (brick.empty || code == 255) return brick;
  float until = cells_of(hidden_until(cut_span, float(code) / 254.0));
  int hidden = int(floor(clamp(until, -1.0e9, 1.0e9))) - 1;
  if (hidden < n) return brick;
  return Brick(true, min(hidden, max(n, brick.until - 2)));
}
#endif
