// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The mean of the transfer function over the values between two points of a ray. It comes from the
// function's integrals over HU as whole numbers, because their differences are exact, but those of
// floats cancel.
// Each entry has three texels: colour times extinction, and extinction; their differences to the
// next entry; the integrals of both in quanta. Before the first entry there is one for values below
// it.
#ifdef STORAGE
layout(std430, binding = 2) readonly buffer Points { ivec4 points[]; };
#define point_texel(i) points[i]
#else
uniform isamplerBuffer points;
#define point_texel(i) texelFetch(points, i)
#endif
uniform float quantum;         // HU/mm.

float hu_of_quantum;           // A copy: taken_over.glsl.

void take_over_integrals() { hu_of_quantum = taken_over(quantum); }

// A value that was looked up.
struct Point {
  float x;         // HU above the first entry.
  int entry;       // Entry at or below the value; -1 below the first.
  ivec4 integral;  // Integral up to the entry.
  vec4 rest;       // Integral from the entry to x, HU/mm.
  vec4 here;       // Colour times extinction, and extinction; per mm.
};

Point no_point() { return Point(0.0, 0, ivec4(0), vec4(0.0), vec4(0.0)); }

Point point_at(float hu) {
  Point p;
  p.x = hu - first_hu;
  p.entry = clamp(int(floor(p.x)), -1, last_entry_of_row);
  float w = p.x - float(max(p.entry, 0));
  int first = 3 * p.entry + 3;
  vec4 low = intBitsToFloat(point_texel(first));
  vec4 slope = intBitsToFloat(point_texel(first + 1));
  p.integral = point_texel(first + 2);
  p.rest = w * fma(vec4(0.5 * w), slope, low);
  p.here = fma(vec4(w), slope, low);
  return p;
}

// The mean over the values from a to b: colour times extinction, and extinction, per mm; not
// clamped to their bounds yet. bow: by how much the mean of the values lies above the mean of the
// line, HU.
vec4 mean_between(Point a, Point b, float bow) {
  const float kSame = 1.0 / 64.0;  // HU; below it the mean of the ends is as good.
  const float kMaxBowShare = 0.5;
  float dx = b.x - a.x;
  bool same = a.entry == b.entry || abs(dx) < kSame;
  vec4 area = fma(vec4(b.integral - a.integral), vec4(hu_of_quantum), b.rest - a.rest);
  vec4 mean = 0.5 * (a.here + b.here);
  float per = 1.0 / (same ? 1.0 : dx);
  float share = clamp(bow * per, -kMaxBowShare, kMaxBowShare);
  if (!same) mean = fma(area, vec4(per), share * (b.here - a.here));
  return mean;
}

// The appearance of such a mean: rgb, not premultiplied, and extinction.
vec4 appearance_of(vec4 mean) {
  if (!(mean.a > 0.0)) return vec4(0.0);
  return vec4(clamp(mean.rgb / mean.a, 0.0, 1.0), mean.a);
}
