// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// All surfaces of a scene.

#include "include/surfaces.glsl"
#ifdef PLANE
#include "include/plane.glsl"
#endif
#ifdef SOLIDS
#include "include/solids.glsl"
#endif

// The first surface of the ray behind a position on it and before t_stop.
Surface next_surface(Ray ray, float t_eye, float t_stop, float after_t, int after_order) {
  Surface best = kNoSurface;
#ifdef PLANE
  keep_nearer(best, hit_plane(ray, t_eye), after_t, after_order);
#endif
#ifdef SOLIDS
  for (int i = 0; i < solid_count; ++i)
    keep_nearer(best, hit_solid(i, ray, t_eye), after_t, after_order);
#endif
  if (best.t >= t_stop) return kNoSurface;
  return best;
}
