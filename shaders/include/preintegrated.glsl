// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Mean of the transfer function over the values between two points of a ray, from its integrals
// over HU as whole numbers: their differences are exact, where those of floats cancel.

// Of each entry three texels: colour times extinction, and extinction; what to add to reach the next
// entry; the integrals of both in quanta. In front of the first entry is one for values below it.
#ifdef STORAGE
layout(std430, binding = 2) readonly buffer Points { ivec4 points[]; };
#define point_texel(i) points[i]
#else
uniform isamplerBuffer points;
#define point_texel(i) texelFetch(points, i)
#endif
uniform float quantum;         // HU/mm.

float hu_of_quantum;           // Taken over.

void take_over_integrals() { hu_of_quantum = taken_over(quantum); }

// A value, looked up.
struct Point {
  float x;         // HU above the first entry.
  int entry;       // At or below; -1 below the first.
  ivec4 integral;  // To the entry.
  vec4 rest;       // From the entry to x, HU/mm.
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

// Mean over the values from a to b: colour times extinction, and extinction, per mm; neither is held
// within its bounds yet. bow: by how much the mean of the values lies above that of the line, HU.
vec4 mean_between(Point a, Point b, float bow) {
  const float kSame = 1.0 / 64.0;  // HU; so close, the mean of the ends is as good.
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

// What such a mean looks like: rgb, not premultiplied, and extinction.
vec4 look_of(vec4 mean) {
  if (!(mean.a > 0.0)) return vec4(0.0);
  return vec4(clamp(mean.rgb / mean.a, 0.0, 1.0), mean.a);
}
