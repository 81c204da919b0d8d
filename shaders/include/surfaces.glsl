// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The common part of all surfaces on a ray. order: 0 for the plane, then the solids; it decides
// between surfaces at equal t.

const float kNever = 3.0e38;

struct Surface {
  float t;  // mm; kNever: no surface.
  int order;
  vec3 rgb;     // [0, 1], not premultiplied.
  float alpha;  // [0, 1].
  bool live;    // The ultrasound image: rg are its column and row, and the layer ends here.
};

const Surface kNoSurface = Surface(kNever, 0, vec3(0.0), 0.0, false);

// Keeps the nearer of two surfaces among those behind a position on the ray.
void keep_nearer(inout Surface best, Surface other, float after_t, int after_order) {
  bool behind = other.t > after_t || (other.t == after_t && other.order > after_order);
  if (behind && other.t < kNever && (other.t < best.t || (other.t == best.t && other.order < best.order)))
    best = other;
}
