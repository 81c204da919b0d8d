// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Composites a stretch of a ray cell by cell, in runs of cells between leaps. If possible, four
// cells are written one after the other: in each turn of a loop software rasterisers copy
// everything that the loop changes, because some rays may have left it. Then those of the four that
// need it are shaded. Otherwise a run pauses at each cell that needs shading, so that a device that
// runs many rays in step shades all of them together.
#if defined(UNROLLED) && defined(PREINTEGRATED) && !defined(TWO_VOLUMES)
#define FOUR_AT_ONCE
#endif

// A part of a cell, and its appearance.
struct Cell {
  float middle;       // Middle of the whole cell, in cells.
  float begin, end;   // Limits of the part, in cells.
  float v_a, v_b;     // Values at the limits, HU.
  vec4 appearance;    // rgb, not premultiplied, and extinction per mm.
  float importance;   // 1 if it is not needed.
};

#if defined(CUTAWAY) || defined(EMPHASIS)
// The mean of equidistant midpoints of a part of a cell. fading: each one is faded at its own
// position.
void classify_in_steps(inout Cell cell, float gradient, bool fading) {
  vec4 sum = vec4(0.0);
  float weighted = 0.0;
  for (int i = 0; i < kFadeSteps; ++i) {
    float w = (float(i) + 0.5) / float(kFadeSteps);
    float importance;
    vec4 appearance = transfer_at(cell.v_a + w * (cell.v_b - cell.v_a), gradient, importance);
    float tau = appearance.a;
#ifdef CUTAWAY
    if (fading) {
      float t = t_of(cell.begin + w * (cell.end - cell.begin));
      tau = faded(tau, visibility(importance, occlusion(cut_span, t)));
    }
#endif
    sum += vec4(tau * appearance.rgb, tau);
    weighted += tau * importance;
  }
  bool visible = sum.a > 0.0;
  cell.importance = visible ? weighted / sum.a : 1.0;
  cell.appearance = visible ? vec4(sum.rgb / sum.a, sum.a / float(kFadeSteps)) : vec4(0.0);
}

bool varies(vec2 ends) { return abs(ends.x - ends.y) > kFadeVaries; }

// The importances at the ends of a part.
vec2 importances_of(Cell cell, float gradient) {
  return vec2(importance_at(cell.v_a, gradient), importance_at(cell.v_b, gradient));
}

// Sets the importance of a cell.
void weigh(inout Cell cell, float gradient, vec2 ends) {
  if (varies(ends)) {
    vec4 appearance = cell.appearance;
    classify_in_steps(cell, gradient, false);
    cell.appearance = appearance;
  } else {
    cell.importance = 0.5 * (ends.x + ends.y);
  }
}
#endif

#ifdef CUTAWAY
// Fades a cell that was classified without a cutaway, and finds its importance.
void fade(inout Cell cell, float gradient) {
  vec2 importance = importances_of(cell, gradient);
  vec2 visible = vec2(visibility(importance.x, occlusion(cut_span, t_of(cell.begin))),
                      visibility(importance.y, occlusion(cut_span, t_of(cell.end))));
  if (varies(visible)) {
    classify_in_steps(cell, gradient, true);
  } else {
#ifdef EMPHASIS
    weigh(cell, gradient, importance);
#endif
    cell.appearance.a = faded(cell.appearance.a, 0.5 * (visible.x + visible.y));
  }
}
#endif

float length_mm(Cell cell) { return (cell.end - cell.begin) * cell_mm; }

void composite(Cell cell) {
  put_behind(layer, cell.appearance.rgb, opacity_of(cell.appearance.a * length_mm(cell)));
}

#ifdef PREINTEGRATED
// Composites a mean of mean_between() over a length.
void composite_mean(vec4 mean, float length_mm) {
  float extinction = max(mean.a, 0.0);
  float part = (1.0 - layer.a) * opacity_of(extinction * length_mm);
  float per = part / max(extinction, 1.0e-30);
  layer += vec4(per * clamp(mean.rgb, vec3(0.0), vec3(extinction)), part);
}
#endif

#ifdef SHADING
// Composites a cell at which the march paused.
void shade_and_composite(Cell cell, bool fading) {
#if defined(EMPHASIS) && defined(PREINTEGRATED)
  if (!fading) weigh(cell, 0.0, importances_of(cell, 0.0));
#endif
#ifdef EMPHASIS
  float share = 1.0 - emphasised * (1.0 - cell.importance);
#else
  const float share = 1.0;
#endif
#ifdef PREINTEGRATED
  float opacity = opacity_of(cell.appearance.a * length_mm(cell));
  if (share > 0.0) {
    // The mean of the shades at several positions: spec::shades_of().
    float weight = (1.0 - layer.a) * opacity;
    float places = clamp(floor(shades_taken * sqrt(weight) + 0.5), 1.0, kMostShades);
    float apart = 1.0 / places;
    float at = cell.middle - 0.5 + 0.5 * apart;
    vec3 sum = vec3(0.0);
    float place = 0.5;
    do {
      sum += shaded(cell.appearance.rgb, gradient_at(index_at(at)), share);
      at += apart;
      place += 1.0;
    } while (place < places);
    cost.y += places;
    cell.appearance.rgb = sum / places;
  }
  put_behind(layer, cell.appearance.rgb, opacity);
#else
  if (share > 0.0) {
    cost.y += 1.0;
    cell.appearance.rgb = shaded(cell.appearance.rgb, gradient_at(index_at(cell.middle)), share);
  }
  composite(cell);
#endif
}
#endif

// A walk along a stretch of a ray.
struct Walk {
  float begin, end;  // In cells.
  int last;          // Lattice point that ends the last cell.
  int j;             // Next lattice point to sample.
  int run_end;       // Cells that begin before it are taken without a brick test.
  int next;          // Position of the next brick test.
  bool pending;      // The cell before next begins in an empty brick and is still to be handled.
  bool going;
  int known;         // Lattice point of v0; far in front: none yet.
  float v0;
#ifdef PREINTEGRATED
  float before;      // The value at the lattice point before known,
  float aside;       // See look_aside().
  Point a;           // The point there, or at the start of the stretch.
#endif
};

Walk begin_walk(float begin, float end) {
  Walk w;
  w.begin = begin;
  w.end = end;
  w.j = w.next = int(floor(begin));
  w.last = end > begin ? int(ceil(end)) : w.j;
  w.pending = false;
  w.going = w.last > w.j;
  w.known = w.j - 2;
  w.v0 = 0.0;
#ifdef PREINTEGRATED
  w.before = w.aside = 0.0;
  w.a = no_point();
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

bool in_run(Walk w) { return w.j - 1 < w.run_end; }

#ifdef SKIPPING
// Begins a run in an occupied brick at next.
void begin_run(inout Walk w, Brick brick) {
#ifdef PREINTEGRATED
  int start = w.pending ? w.next - 1 : w.next;
  bool goes_on = w.known == start;
  w.j = goes_on ? start + 1 : start;
  w.run_end = w.next = min(goes_on ? start + kRun : start + kRun - 1, w.last);
  w.pending = false;
#else
  w.j = w.next;
  w.next = min(brick.until, w.last);
  w.run_end = w.next - 1;
#endif
}

// Leaps to the next run; if there is none, the walk is over.
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

// The part of the cell between lattice points k and k + 1 that lies in the stretch.
Cell cell_at(Walk w, int k, float v0, float v1) {
  float from = max(w.begin - float(k), 0.0);
  float to = min(w.end - float(k), 1.0);
  Cell cell;
  cell.v_a = fma(from, v1 - v0, v0);
  cell.v_b = to < 1.0 ? fma(to, v1 - v0, v0) : v1;
  cell.begin = float(k) + from;
  cell.end = float(k) + to;
  cell.middle = float(k) + 0.5;
  cell.importance = 1.0;
  cell.appearance = vec4(0.0);
  return cell;
}

#ifdef PREINTEGRATED
// True if the stretch begins in the cell whose first lattice point is sampled next.
bool begins_inside(Walk w) { return float(w.j) < w.begin; }

// A run that does not continue the last one takes a value beside its first one. That is the value
// at the lattice point before it, for the bow of the first cell. If the stretch begins in that
// cell, it is the value at the lattice point after it, for the value at the start.
void look_aside(inout Walk w) {
  if (w.known == w.j - 1) return;
  w.aside = value_at(float(begins_inside(w) ? w.j + 1 : w.j - 1));
}

// The bow of the cell from k on, HU. v1: the value at its end.
float bow_of(Walk w, Cell cell, int k, float v1) {
  bool whole = cell.begin >= float(k) && cell.begin <= float(k) && cell.end >= float(k + 1);
  bool may_bow = whole && k >= bow_from;
  return may_bow ? (2.0 * w.v0 - w.before - v1) / 12.0 : 0.0;
}

void advance(inout Walk w, float v1) {
  w.known = w.j;
  w.v0 = v1;
  ++w.j;
}

// Takes the sample at j. Returns true if it ends a cell; mean is then the mean over that cell, see
// mean_between(). The first sample of a run goes through the same operations without need, because
// a device that runs many rays in step would execute both sides of a branch anyway.
bool take_sample(inout Walk w, bool may_begin, out Cell cell, out vec4 mean) {
  int k = w.j - 1;
  bool whole = w.known == k;  // v0 and v1 are the values of a cell.
  float v1 = value_at(float(w.j));
  cell = cell_at(w, k, w.v0, v1);
  float v = whole ? cell.v_b : v1;
  if (may_begin && begins_inside(w)) v = v1 + (w.begin - float(w.j)) * (w.aside - v1);
  Point b = point_at(v);
  mean = mean_between(w.a, b, bow_of(w, cell, k, v1));
  w.a = b;
  w.before = whole ? w.v0 : w.aside;
  advance(w, v1);
  return whole;
}
#else
void take_middle(inout Walk w, out Cell cell, bool fading) {
  float v = value_at(float(w.j) + 0.5);
  cell = cell_at(w, w.j, v, v);
#ifdef GRADIENT_WINDOWS
  float gradient = length(gradient_at(index_at(cell.middle)));
#else
  const float gradient = 0.0;
#endif
  cell.appearance = transfer_at(v, gradient, cell.importance);
#ifdef CUTAWAY
  if (fading) {
    cost.z += 1.0;
    fade(cell, gradient);
  }
#endif
  ++w.j;
}
#endif

#ifdef FOUR_AT_ONCE
// Beyond its end a run takes cells that are no reason for a brick test, but nothing beyond the
// stretch.
#ifdef SHADING
// A cell that waits for shading. If the sample ends no cell, its end equals its begin.
Cell take_one(inout Walk w, bool may_begin) {
  Cell cell;
  vec4 mean;
  if (!take_sample(w, may_begin, cell, mean)) cell.end = cell.begin;
  cell.appearance = mean;
  return cell;
}

int bit_of(Cell cell, int bit) {
  return cell.end > cell.begin && cell.appearance.a > 0.0 ? bit : 0;
}

bool take_four(inout Walk w) {
  Cell a = take_one(w, true);
  Cell b = take_one(w, false);
  Cell c = take_one(w, false);
  Cell d = take_one(w, false);
  w.next = max(w.next, w.known);
  int left = bit_of(a, 1) | bit_of(b, 2) | bit_of(c, 4) | bit_of(d, 8);
  if (left != 0) do {
    Cell cell = d;
    if ((left & 4) != 0) cell = c;
    if ((left & 2) != 0) cell = b;
    if ((left & 1) != 0) cell = a;
    cell.appearance = appearance_of(cell.appearance);
    shade_and_composite(cell, false);
    left = layer.a < enough ? left & (left - 1) : 0;
  } while (left != 0);
  return layer.a >= enough;
}
#else
void take_one(inout Walk w, bool may_begin) {
  Cell cell;
  vec4 mean;
  bool whole = take_sample(w, may_begin, cell, mean);
  composite_mean(mean, whole && layer.a < enough ? max(length_mm(cell), 0.0) : 0.0);
}

bool take_four(inout Walk w) {
  take_one(w, true);
  take_one(w, false);
  take_one(w, false);
  take_one(w, false);
  w.next = max(w.next, w.known);
  return layer.a >= enough;
}
#endif
#endif

// Takes the next sample and composites the cell that it completes. Returns true if there is a
// reason to pause. With SHADING that is the cell itself, which is not composited yet.
bool take_next(inout Walk w, inout Cell cell, bool fading) {
  bool found = true;
#ifdef PREINTEGRATED
  vec4 mean;
  found = take_sample(w, true, cell, mean);
#if defined(SHADING) || defined(CUTAWAY)
  cell.appearance = appearance_of(mean);
#endif
#ifdef CUTAWAY
  if (fading && found) {
    cost.z += 1.0;
    fade(cell, 0.0);
  }
#endif
#ifndef SHADING
  if (!fading) composite_mean(mean, found ? length_mm(cell) : 0.0);
#endif
#else
  take_middle(w, cell, fading);
#endif
#ifdef SHADING
  return found && cell.appearance.a > 0.0;
#else
#ifdef PREINTEGRATED
  if (fading && found) composite(cell);
#else
  composite(cell);
#endif
  return layer.a >= enough;
#endif
}

#ifdef TWO_VOLUMES
float clear_to;  // Cells before this one that are still to come show nothing.

#ifdef PREINTEGRATED
// The point at which the last stretch ended, if it was a lattice point: the next stretch begins
// there.
int kept_at;  // Far in front: none.
float kept_v;
float v_kept_before;
Point kept_a;

void forget() { kept_at = -1000000000; }

void keep(Walk w, bool fading) {
  kept_at = !fading && w.end == float(w.known) ? w.known : -1000000000;
  kept_v = w.v0;
  v_kept_before = w.before;
  kept_a = w.a;
}

void resume(inout Walk w) {
  if (!w.going || w.begin != float(kept_at)) return;
  w.known = kept_at;
  w.v0 = kept_v;
  w.before = v_kept_before;
  w.a = kept_a;
#ifndef SKIPPING
  ++w.j;
#endif
}
#endif
#endif

// Loops are tested at their ends: a device that runs many rays in step executes the body of a loop
// once more after the last ray has left it at its head.
// begin, end: in cells. fading: in front of the surface of theta2.
void march(float begin, float end, bool fading) {
  Walk w = begin_walk(begin, end);
#if defined(TWO_VOLUMES) && defined(PREINTEGRATED)
  if (!fading) resume(w);
#endif
  if (w.going) do {
#ifdef SKIPPING
    find_run(w, fading);
#endif
#ifdef PREINTEGRATED
    look_aside(w);
#endif
    Cell cell;
    bool found = false;
    if (in_run(w)) do {
#ifdef FOUR_AT_ONCE
      found = fading ? take_next(w, cell, true) : take_four(w);
#else
      found = take_next(w, cell, fading);
#endif
    } while (in_run(w) && !found);
#ifdef SHADING
#ifdef FOUR_AT_ONCE
    if (found && fading) shade_and_composite(cell, true);
#else
    if (found) shade_and_composite(cell, fading);
#endif
#endif
    if (layer.a >= enough) w.going = false;
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

#ifdef CUTAWAY
// A stretch in a cutaway: cells that begin in front of the surface of theta2 fade. There are two
// calls of march() only if that is cheaper: compilers of devices take twice the time for twice the
// text.
void march_cut(float begin, float end) {
  float fade = cells_of(cut_span.t2);
  float turn = fade > begin ? clamp(ceil(min(fade, 1.0e9)), begin, max(begin, end)) : begin;
#ifdef UNROLLED
  march(begin, min(turn, end), true);
  if (layer.a < enough) march(turn, end, false);
#else
  bool fading = end > begin;
  bool going = fading;
  while (going) {
    march(fading ? begin : turn, fading ? min(turn, end) : end, fading);
    going = fading && layer.a < enough;
    fading = false;
  }
#endif
}
#endif
