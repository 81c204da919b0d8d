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

// Loops are tested at their ends: a device that runs many rays in step goes through the body of a
// loop once more after the last ray has left it at its head.
// begin, end: cells. fading: in front of the surface of theta2.
void march(float begin, float end, bool fading) {
  int first = int(floor(begin));
  int last = end > begin ? int(ceil(end)) : first;  // Lattice point that ends the last cell.
  Cell cell;
  // Samples up to run_end may be taken without looking at bricks; next: where to look again.
  int j = first;
#ifdef SKIPPING
  int run_end = first - 1;
  int next = first;
  bool pending = false;  // The cell before next begins in an empty brick and is not yet dealt with.
#elif defined(PREINTEGRATED)
  int run_end = last > first ? last : first - 1;
#else
  int run_end = last - 1;
#endif
#ifdef PREINTEGRATED
  int known = first - 2;  // Lattice point of v0; none yet.
  float v0 = 0.0;
  Point a;
  bool has_a = false;     // a is what lies at the begin of the part of the cell after it.
#endif
  bool marching = last > first;
  if (marching) do {
#ifdef SKIPPING
    if (j > run_end) do {
      if (pending ? next > last : next >= last) {
        marching = false;
      } else {
#ifdef CUTAWAY
        Brick brick = fading ? fading_brick_at(next) : brick_at(next);
#else
        Brick brick = brick_at(next);
#endif
        if (brick.empty) {
          next = brick.until + 1;
#ifdef PREINTEGRATED
          pending = true;
#endif
        } else {
#ifdef PREINTEGRATED
          int start = pending ? next - 1 : next;
          j = known == start ? start + 1 : start;
          run_end = next = min(brick.until, last);
          pending = false;
#else
          j = next;
          next = min(brick.until, last);
          run_end = next - 1;
#endif
        }
      }
    } while (j > run_end && marching);
#endif
    bool found = false;
    if (j <= run_end) do {
#ifdef PREINTEGRATED
      float v1 = value_at(float(j));
      int k = j - 1;
      bool whole = known == k;  // v0 and v1 are the values of a cell.
#else
      float v1 = value_at(float(j) + 0.5);
      float v0 = v1;
      int k = j;
      const bool whole = true;
#endif
      float from = max(begin - float(k), 0.0);
      float to = min(end - float(k), 1.0);
      cell.v_a = v0 + from * (v1 - v0);
      cell.v_b = to < 1.0 ? v0 + to * (v1 - v0) : v1;
      cell.begin = float(k) + from;
      cell.end = float(k) + to;
      cell.middle = float(k) + 0.5;
      cell.importance = 1.0;
      cell.look = vec4(0.0);
      bool classified = whole;
#ifdef PREINTEGRATED
      bool advance = true;
      if (fading) {
        cost.z += float(whole);
        if (whole) classify_in_steps(cell, 0.0, true);
      } else {
        // The begin of the stretch lies inside a cell: it is looked up once both ends are known.
        bool at_begin = whole && !has_a;
        Point b = point_at(at_begin ? cell.v_a : whole ? cell.v_b : v1);
        classified = whole && has_a;
        if (classified) cell.look = mean_between(a, b);
        a = b;
        advance = !at_begin;
        has_a = whole || begin <= float(j);
      }
      if (advance) {
        known = j;
        v0 = v1;
        ++j;
      }
#else
#ifdef GRADIENT_WINDOWS
      float gradient = length(gradient_at(index_at(cell.middle)));
#else
      const float gradient = 0.0;
#endif
      if (fading) {
        cost.z += 1.0;
        classify_in_steps(cell, gradient, true);
      } else {
        cell.look = transfer_at(v1, gradient, cell.importance);
      }
      ++j;
#endif
      found = classified && cell.look.a > 0.0;
#ifndef SHADING
      if (found) composite(cell);
      found = picture.a >= enough;
#endif
    } while (j <= run_end && !found);
#ifdef SHADING
    if (found) shade_and_composite(cell, fading);
#endif
    if (picture.a >= enough) marching = false;
#ifndef SKIPPING
    if (j > run_end) marching = false;
#endif
  } while (marching);
}
