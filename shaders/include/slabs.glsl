// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The slabs in which two volumes are composited: render/spec/ray_spec.hpp, "Two volumes".
// Successive parts of one volume without the other volume in between are taken as one stretch,
// because samples of one importance may be composited before the rest. So the CT runs between the
// odd multiples of a slab, and the ultrasound between the even ones, in turn. Stretch n ends at n
// slabs: odd n belong to the CT, even n to the ultrasound. All rays take the turn of the CT at the
// same time.

uniform float slab_mm;  // t = 0 is an even multiple.

// A part of a ray in front of a surface, in mm.
struct Slabs {
  vec2 ct;          // The part of the ray in the CT,
  vec2 ultrasound;  // in the ultrasound,
  vec2 both;        // and in both. If there is none, the end of the first volume.
  int first;        // The stretch after the one that ends where both begins.
  int last;         // The first stretch that reaches the end of both.
};

Slabs slabs_between(float begin, float end, vec2 ct_box, vec2 ultrasound_box) {
  Slabs s;
  s.ct = vec2(max(begin, ct_box.x), min(end, ct_box.y));
  s.ultrasound = vec2(max(begin, ultrasound_box.x), min(end, ultrasound_box.y));
  s.both = vec2(max(s.ct.x, s.ultrasound.x), min(s.ct.y, s.ultrasound.y));
  if (!(s.both.y > s.both.x))
    s.both = vec2(clamp(min(ct_box.y, ultrasound_box.y), begin, max(begin, end)));
  s.first = int(floor(s.both.x / slab_mm)) + 1;
  s.last = max(int(ceil(s.both.y / slab_mm)), s.first);
  return s;
}

// The first turn of the CT.
int first_turn(Slabs s) { return s.first - 1 - (s.first & 1); }
int last_turn(Slabs s) { return s.last + 3; }

// Stretch n of a volume. own: its part of the ray. Empty if y <= x.
vec2 stretch_of(Slabs s, int n, vec2 own) {
  if (n < s.first - 1 || n > s.last + 3) return vec2(0.0);
  float from = n <= s.first ? own.x : max(float(n - 2) * slab_mm, s.both.x);
  float to = n < s.first ? s.both.x : min(float(n) * slab_mm, s.both.y);
  if (n >= s.last + 2) {  // The rest.
    from = s.both.y;
    to = own.y;
  }
  return vec2(max(from, own.x), min(to, own.y));
}

// The next turn of the CT if neither volume shows anything before a position in both.
int turn_after(Slabs s, int n, float clear_mm) {
  const float kMargin = 0.01;  // In slabs; more than rounding.
  int clear = int(floor(min(clear_mm, s.both.y) / slab_mm - kMargin));
  return max(n + 2, clear | 1);
}

// Slabs end at whole cells of the volume with the coarser cells, except for rounding.
float whole_cells(float cells) {
  float rounding = 1.0e-6 * (100.0 + abs(cells));
  float nearest = floor(cells + 0.5);
  return abs(cells - nearest) < rounding ? nearest : cells;
}
