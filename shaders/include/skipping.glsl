// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Exact leaps over bricks in which nothing is visible. A cell is leapt over only if every position
// that it samples lies in such a brick. For the two ends of a pre-integrated cell that is enough:
// bricks that touch share voxels, so their ranges of values overlap, and the values between the
// ends are in one range or the other. (Steps are at most a brick long where this is compiled.)
// Data of a brick: the distance to the nearest occupied brick, in bricks along the longest axis;
// the greatest importance; the parts of its eight that may show something, bit i + 2 j + 4 k. Parts
// are leapt over like bricks, as long as cells are no longer than parts.

uniform int all_parts;  // 255 if cells are too long: all parts count as occupied. Otherwise 0.
int all_parts_taken;

void take_over_skipping() {
  take_over_bricks();
  all_parts_taken = taken_over(all_parts);
}

// In an occupied brick a ray tests again after this many samples, wherever it leaves the brick:
// rays that run in step would wait for the one that leaves last, so they may as well sample.
const int kRun = 8;

// The brick in which a ray takes one of its samples.
struct Brick {
  bool empty;  // Nothing is visible here.
  int until;   // Empty: the last sample that surely is. Otherwise the next one to test.
};

Brick brick_at(int n) {
  vec3 place = index_at(float(n) + kPlace) * bricks_a_voxel;
  ivec3 at = clamp(ivec3(floor(place)), ivec3(0), last_brick);
  uvec3 known = texelFetch(bricks, at, 0).rgb;
  ivec3 part = ivec3(greaterThanEqual(place - vec3(at), vec3(0.5)));
  bool shows = ((known.b | uint(all_parts_taken)) >> uint(part.x + 2 * part.y + 4 * part.z) & 1u) != 0u;
  bool far = known.r > 0u;
  bool empty = far || !shows;
  // An empty region is left slightly early.
  float reach = float(known.r);
  vec3 low = vec3(at) + (far ? vec3(1.0 - reach) : 0.5 * vec3(part));
  float size = far ? 2.0 * reach - 1.0 : 0.5;
  int inside = int(floor(leaves_box(low, low + size, -rounding)));
  return Brick(empty, empty ? max(inside, n) : n + kRun);
}

#ifdef CUTAWAY
// Does the same in the part of a ray that fades: an occupied brick counts as empty where its greatest
// importance cannot be visible yet. A cell is leapt over if it ends before that position.
Brick fading_brick_at(int n) {
  ivec3 at = brick_of(n);
  uvec2 known = texelFetch(bricks, at, 0).rg;
  bool empty = known.r > 0u;
  float leaves = leaves_cube(at, int(max(known.r, 1u)), empty ? -rounding : rounding);
  int inside = max(int(floor(leaves)), n);
  if (empty) return Brick(true, inside);
  float until = cells_of(hidden_until(cut_span, float(known.g) / 254.0));
  int hidden = int(floor(clamp(until, -1.0e9, 1.0e9))) - 1;
  if (known.g == 255u || hidden < n) return Brick(false, n + kRun);
  return Brick(true, min(hidden, max(n, inside - 1)));
}
#endif
