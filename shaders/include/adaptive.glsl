// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Several cells taken as one, by the rule of render/quality/adaptive_step.hpp.

uniform usampler3D brick_cells;  // The number of cells that a segment may have in each brick.

int known_until = -1;  // The last lattice point that is surely in the brick that was looked up.
int known_from = 0;    // The first one.
int known_most = 1;

// The number of cells from lattice point k on that form a segment of a stretch. begin, end: in
// cells.
int cells_from(int k, float begin, float end) {
  if (k > known_until || k < known_from) {
    ivec3 at = brick_of(k);
    known_from = k;
    known_until = max(k, int(floor(leaves_cube(at, 1, -rounding))));
    known_most = int(texelFetch(brick_cells, at, 0).r);
  }
  int most = min(known_most, min(known_until, int(floor(end))) - k);
  return float(k) < begin ? 1 : max(most, 1);
}
