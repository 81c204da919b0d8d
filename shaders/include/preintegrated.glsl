// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Mean of the transfer function over the values between two points of a ray, from its integrals
// over HU as whole numbers: their differences are exact, where those of floats cancel.

uniform isamplerBuffer integrals;  // Of colour times extinction, and of extinction, in quanta.
uniform float quantum;         // HU/mm.

// A value, looked up.
struct Point {
  float x;         // HU above the first entry.
  int entry;       // At or below; -1 below the first.
  ivec4 integral;  // To the entry.
  vec4 rest;       // From the entry to x, HU/mm.
  vec4 here;       // Colour times extinction, and extinction; per mm.
};

vec4 premultiplied(vec4 value) { return vec4(value.rgb * value.a, value.a); }

Point point_at(float hu) {
  Point p;
  p.x = hu - transfer_first_hu;
  p.entry = clamp(int(floor(p.x)), -1, transfer_size - 1);
  int i = max(p.entry, 0);
  float w = p.x - float(i);
  vec4 low = premultiplied(transfer_entry(i));
  vec4 slope = premultiplied(transfer_entry(min(p.entry + 1, transfer_size - 1))) - low;
  p.integral = texelFetch(integrals, i);
  p.rest = w * (low + 0.5 * w * slope);
  p.here = low + w * slope;
  return p;
}

// Mean over the values from a to b: rgb, not premultiplied, and extinction per mm. bow: by how much
// the mean of the values lies above that of the line, HU.
vec4 mean_between(Point a, Point b, float bow) {
  const float kSame = 1.0 / 64.0;  // HU; so close, the mean of the ends is as good.
  const float kMaxBowShare = 0.5;
  float dx = b.x - a.x;
  bool same = a.entry == b.entry || abs(dx) < kSame;
  vec4 area = vec4(b.integral - a.integral) * quantum + (b.rest - a.rest);
  vec4 mean = 0.5 * (a.here + b.here);
  if (!same) mean = area / dx + clamp(bow / dx, -kMaxBowShare, kMaxBowShare) * (b.here - a.here);
  if (!(mean.a > 0.0)) return vec4(0.0);
  return vec4(clamp(mean.rgb / mean.a, 0.0, 1.0), mean.a);
}
