// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Leaps over bricks where nothing can be seen, exactly: a cell is leapt over only when every place
// that it samples lies in such a brick. For the two ends of a pre-integrated cell that is enough:
// bricks that touch share voxels, so their ranges of values overlap, and the values between the
// ends are in one range or the other. (Steps are at most a brick long where this is compiled.)
// Known of a brick: distance to the nearest occupied one, in bricks along the longest axis;
// greatest importance.

// In an occupied brick a ray looks again after this many samples, wherever it leaves the brick: rays
// that run in step would wait for the one that leaves last, and may as well sample.
const int kRun = 8;

// What a ray meets at one of its samples.
struct Brick {
  bool empty;  // Nothing can be seen here.
  int until;   // Empty: the last sample that is surely so. Else the first one to look at again.
};

Brick brick_at(int n) {
  ivec3 at = brick_of(n);
  uvec2 known = texelFetch(bricks, at, 0).rg;
  bool empty = known.r > 0u;
  // An empty region is left a little early.
  int inside = int(floor(leaves_cube(at, int(known.r), -rounding)));
  return Brick(empty, empty ? max(inside, n) : n + kRun);
}

#ifdef CUTAWAY
// The same in the part of a ray that fades: what is occupied counts as empty where its greatest
// importance cannot be visible yet. A cell is leapt over when it ends before that place.
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
