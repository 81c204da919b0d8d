// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Composites a stretch of a ray cell by cell. Runs of cells between leaps; a run pauses at each cell
// that needs shading, so that a device that runs many rays in step shades all of them together.

// Part of a cell and how it looks.
struct Cell {
  float middle;       // Of the whole cell, cells.
  float begin, end;   // Of the part, cells.
  float v_a, v_b;     // Values there, HU.
  vec4 look;          // rgb, not premultiplied, and extinction per mm.
  float importance;   // 1 where it is not needed.
};

// The mean of equidistant midpoints of a part of a cell, each faded at its own place if asked.
void classify_in_steps(inout Cell cell, float gradient, bool fading) {
  vec4 sum = vec4(0.0);
  float weighted = 0.0;
  for (int i = 0; i < kFadeSteps; ++i) {
    float w = (float(i) + 0.5) / float(kFadeSteps);
    float importance;
    vec4 look = transfer_at(cell.v_a + w * (cell.v_b - cell.v_a), gradient, importance);
    float tau = look.a;
#ifdef CUTAWAY
    if (fading) {
      float t = t_of(cell.begin + w * (cell.end - cell.begin));
      tau = faded(tau, visibility(importance, occlusion(cut_span, t)));
    }
#endif
    sum += vec4(tau * look.rgb, tau);
    weighted += tau * importance;
  }
  bool visible = sum.a > 0.0;
  cell.importance = visible ? weighted / sum.a : 1.0;
  cell.look = visible ? vec4(sum.rgb / sum.a, sum.a / float(kFadeSteps)) : vec4(0.0);
}

float length_mm(Cell cell) { return (cell.end - cell.begin) * step_mm; }

void composite(Cell cell) {
  put_behind(picture, cell.look.rgb, opacity_of(cell.look.a * length_mm(cell)));
}

#ifdef SHADING
// Composites a cell that pausing was worth.
void shade_and_composite(Cell cell, bool fading) {
#if defined(EMPHASIS) && defined(PREINTEGRATED)
  if (!fading) {
    vec4 look = cell.look;
    classify_in_steps(cell, 0.0, false);
    cell.look = look;
  }
#endif
#ifdef EMPHASIS
  float share = 1.0 - emphasis * (1.0 - cell.importance);
#else
  const float share = 1.0;
#endif
  if (share > 0.0) {
    cost.y += 1.0;
    cell.look.rgb = shaded(cell.look.rgb, gradient_at(index_at(cell.middle)), share);
  }
  composite(cell);
}
#endif

// A walk along a stretch of a ray.
struct Walk {
  float begin, end;  // Cells.
  int last;          // Lattice point that ends the last cell.
  int j;             // Where to sample next.
  int size;          // Cells of the segment that ends at j; 1 without ADAPTIVE.
  int run_end;       // Segments that begin before it are taken without looking at bricks.
  int next;          // Where to look at bricks again.
  bool pending;      // The cell before next begins in an empty brick and is not yet dealt with.
  bool going;
  int known;         // Lattice point of v0; far in front: none yet.
  float v0;
#ifdef PREINTEGRATED
  int before_at;     // Lattice point of before.
  float before;
  Point a;
  bool has_a;        // a is what lies at the begin of the part of the cell after it.
#endif
};

Walk begin_walk(float begin, float end) {
  Walk w;
  w.begin = begin;
  w.end = end;
  w.j = w.next = int(floor(begin));
  w.last = end > begin ? int(ceil(end)) : w.j;
  w.size = 1;
  w.pending = false;
  w.going = w.last > w.j;
  w.known = w.j - 2;
  w.v0 = 0.0;
#ifdef PREINTEGRATED
  w.before_at = w.j;
  w.before = 0.0;
  w.has_a = false;
#endif
#if defined(SKIPPING)
  w.run_end = w.j - 1;
#elif defined(PREINTEGRATED)
  w.run_end = w.going ? w.last : w.j - 1;
#else
  w.run_end = w.last - 1;
#endif
  return w;
}

bool in_run(Walk w) { return w.j - w.size < w.run_end; }

#ifdef SKIPPING
// A run in an occupied brick begins at next.
void begin_run(inout Walk w, Brick brick) {
#ifdef PREINTEGRATED
  int start = w.pending ? w.next - 1 : w.next;
#ifdef ADAPTIVE
  if (w.known != start) w.size = 1;
#endif
  w.j = w.known == start ? start + w.size : start;
  w.run_end = w.next = min(brick.until, w.last);
  w.pending = false;
#else
  w.j = w.next;
  w.next = min(brick.until, w.last);
  w.run_end = w.next - 1;
#endif
}

// Leaps to the next run; none: the walk is over.
void find_run(inout Walk w, bool fading) {
  if (!in_run(w)) do {
    if (w.pending ? w.next > w.last : w.next >= w.last) {
      w.going = false;
    } else {
#ifdef CUTAWAY
      Brick brick = fading ? fading_brick_at(w.next) : brick_at(w.next);
#else
      Brick brick = brick_at(w.next);
#endif
      if (brick.empty) {
        w.next = brick.until + 1;
#ifdef PREINTEGRATED
        w.pending = true;
#endif
      } else {
        begin_run(w, brick);
      }
    }
  } while (!in_run(w) && w.going);
}
#endif

// The part of the segment between lattice points k and k + size that lies in the stretch.
Cell cell_at(Walk w, int k, float v0, float v1) {
  float from = max(w.begin - float(k), 0.0);  // Only single cells are cut.
  float to = min(w.end - float(k), 1.0);
  Cell cell;
  cell.v_a = v0 + from * (v1 - v0);
  cell.v_b = to < 1.0 ? v0 + to * (v1 - v0) : v1;
  cell.begin = float(k) + from;
  cell.end = float(k) + to * float(w.size);
  cell.middle = float(k) + 0.5 * float(w.size);
  cell.importance = 1.0;
  cell.look = vec4(0.0);
  return cell;
}

#ifdef PREINTEGRATED
// The segment from k on may have a bow.
bool may_bow(Walk w, int k) { return w.size == 1 && k >= bow_from; }

// The bow of the segment from k on, whose values at its ends are v0 and v1; HU.
float bow_of(Walk w, Cell cell, int k, float v1) {
  bool cut = cell.begin > float(k) || cell.end < float(k + 1);
  return may_bow(w, k) && !cut ? (2.0 * w.v0 - w.before - v1) / 12.0 : 0.0;
}

// Takes the sample at j. True: it ends a cell, which is classified. The value behind the first cell
// of a run is taken by itself, for j is asked for once more: a device that runs many rays in step
// would take a sample in a branch for every cell.
bool take_sample(inout Walk w, out Cell cell, bool fading) {
  int k = w.j - w.size;
  bool whole = w.known == k;  // v0 and v1 are the values of a cell.
  bool behind = whole && !fading && may_bow(w, k) && w.before_at != k - 1;
  float v1 = value_at(float(behind ? k - 1 : w.j));
  cell = cell_at(w, k, w.v0, v1);
  bool classified = whole;
  bool advance = true;
  if (fading) {
    cost.z += float(whole);
    if (whole) classify_in_steps(cell, 0.0, true);
  } else if (behind) {
    w.before_at = k - 1;
    w.before = v1;
    classified = false;
    advance = false;
  } else {
    // The begin of the stretch lies inside a cell: it is looked up once both ends are known.
    bool at_begin = whole && !w.has_a;
    Point b = point_at(at_begin ? cell.v_a : whole ? cell.v_b : v1);
    classified = whole && w.has_a;
    if (classified) cell.look = mean_between(w.a, b, bow_of(w, cell, k, v1));
    w.a = b;
    advance = !at_begin;
    w.has_a = whole || w.begin <= float(w.j);
  }
  if (advance) {
    w.before_at = whole ? k : w.j;
    w.before = w.v0;
    w.known = w.j;
    w.v0 = v1;
#ifdef ADAPTIVE
    w.next = max(w.next, w.known);
    w.size = fading ? 1 : cells_from(w.known, w.begin, w.end);
#endif
    w.j += w.size;
  }
  return classified;
}
#else
bool take_sample(inout Walk w, out Cell cell, bool fading) {
  float v = value_at(float(w.j) + 0.5);
  cell = cell_at(w, w.j, v, v);
#ifdef GRADIENT_WINDOWS
  float gradient = length(gradient_at(index_at(cell.middle)));
#else
  const float gradient = 0.0;
#endif
  if (fading) {
    cost.z += 1.0;
    classify_in_steps(cell, gradient, true);
  } else {
    cell.look = transfer_at(v, gradient, cell.importance);
  }
  ++w.j;
  return true;
}
#endif

#ifdef TWO_VOLUMES
float clear_to;  // Cells before this one that are yet to come show nothing.

#ifdef PREINTEGRATED
// What lies where the last stretch ended, if it was a lattice point: the next one begins there.
int kept_at;  // Far in front: nowhere.
float kept_v;
int kept_behind_at;
float kept_behind;
Point kept_a;

void forget() { kept_at = -1000000000; }

void keep(Walk w, bool fading) {
  kept_at = !fading && w.end == float(w.known) ? w.known : -1000000000;
  kept_v = w.v0;
  kept_behind_at = w.before_at;
  kept_behind = w.before;
  kept_a = w.a;
}

void resume(inout Walk w) {
  if (!w.going || w.begin != float(kept_at)) return;
  w.known = kept_at;
  w.v0 = kept_v;
  w.before_at = kept_behind_at;
  w.before = kept_behind;
  w.a = kept_a;
  w.has_a = true;
#ifdef ADAPTIVE
  w.size = cells_from(w.known, w.begin, w.end);
#endif
#ifndef SKIPPING
  w.j += w.size;
#endif
}
#endif
#endif

// Loops are tested at their ends: a device that runs many rays in step goes through the body of a
// loop once more after the last ray has left it at its head.
// begin, end: cells. fading: in front of the surface of theta2.
void march(float begin, float end, bool fading) {
  Walk w = begin_walk(begin, end);
#if defined(TWO_VOLUMES) && defined(PREINTEGRATED)
  if (!fading) resume(w);
#endif
  if (w.going) do {
#ifdef SKIPPING
    find_run(w, fading);
#endif
    Cell cell;
    bool found = false;
    if (in_run(w)) do {
      found = take_sample(w, cell, fading) && cell.look.a > 0.0;
#ifndef SHADING
      if (found) composite(cell);
      found = picture.a >= enough;
#endif
    } while (in_run(w) && !found);
#ifdef SHADING
    if (found) shade_and_composite(cell, fading);
#endif
    if (picture.a >= enough) w.going = false;
#ifndef SKIPPING
    if (!in_run(w)) w.going = false;
#endif
  } while (w.going);
#if defined(TWO_VOLUMES) && defined(PREINTEGRATED)
  keep(w, fading);
#endif
#if defined(TWO_VOLUMES) && defined(SKIPPING)
  clear_to = max(clear_to, float(w.next - 1));
#endif
}
