#version 410 core
// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Casts one ray per pixel through the CT, the ultrasound plane and the solid shapes. The equations
// and the global lattice of cells are those of render/ray_spec.hpp, which the reference engine runs
// in double. Features that a scene does not use are not compiled: SHADING PLANE NEEDLE SPHERES
// SKIPPING SHARED_DEPTH MANUAL_FILTER.
// Result: premultiplied colour and alpha in [0, 1]; and how many samples and gradients it took.

#if defined(PLANE) || defined(NEEDLE) || defined(SPHERES)
#define SURFACES
#endif

#include "include/camera.glsl"
#include "include/ct.glsl"
#include "include/transfer.glsl"
#include "include/compositing.glsl"
#if defined(SHADING) || defined(NEEDLE) || defined(SPHERES)
#include "include/shading.glsl"
#endif
#ifdef SHARED_DEPTH
#include "include/shared_depth.glsl"
#endif

uniform float step_mm;    // Length of a cell.
uniform float opaque_at;  // The ray ends at this alpha; > 1: never.

layout(location = 0) out vec4 colour;
layout(location = 1) out vec2 cost;  // CT samples, shaded samples.

// Where cell k is sampled. precise: every caller gets the same bits.
vec3 index_at(int k, vec3 origin, vec3 direction) {
  precise vec3 index = origin + (float(k) + 0.5) * step_mm * direction;
  return index;
}

#ifdef SKIPPING
#include "include/skipping.glsl"
#endif

#ifdef SURFACES
#include "include/surfaces.glsl"
#ifdef PLANE
#include "include/plane.glsl"
#endif
#if defined(NEEDLE) || defined(SPHERES)
#include "include/shapes.glsl"
#endif

#ifdef SPHERES
uniform int sphere_count;
#endif

// First surface of the ray behind a place on it.
Surface next_surface(Ray ray, float t_eye, float after_t, int after_order) {
  Surface best = kNoSurface;
#ifdef PLANE
  keep_nearer(best, hit_plane(ray, t_eye), after_t, after_order);
#endif
#ifdef NEEDLE
  keep_nearer(best, hit_needle(ray, t_eye), after_t, after_order);
#endif
#ifdef SPHERES
  for (int i = 0; i < sphere_count; ++i)
    keep_nearer(best, hit_sphere(i, ray, t_eye), after_t, after_order);
#endif
  return best;
}
#endif

void main() {
  Ray ray = ray_of_pixel(gl_FragCoord.xy);
  vec3 origin = index_from_local * ray.origin;
  vec3 direction = index_from_local * ray.direction;
  float t_eye = -t_base_mm;
  vec2 box = clip_to_box(origin, direction, t_eye);
#ifdef SHADING
  vec3 axis_direction = normalize(direction / half_per_spacing);
#endif
#ifdef SHARED_DEPTH
  float t_stop = t_of_geometry(ivec2(gl_FragCoord.xy), ray.direction);
  box.y = min(box.y, t_stop);
#endif
  float begin = box.x;
  float end = box.y;
#ifdef SURFACES
  Surface surface = next_surface(ray, t_eye, t_eye, -1);
#ifdef SHARED_DEPTH
  if (surface.t >= t_stop) surface = kNoSurface;
#endif
  end = min(end, surface.t);
#endif
  int k = int(floor(begin / step_mm));
  vec4 picture = vec4(0.0);
  cost = vec2(0.0);
  for (;;) {
    float low = float(k) * step_mm;
    float high = float(k + 1) * step_mm;
    if (min(high, end) > max(low, begin)) {
#ifdef SKIPPING
      int leap = empty_cells(k, origin, direction);
      if (leap > 0) {
        // Never past the cell that holds the end of this segment.
        int holds_end = int(floor(min(end, 1.0e9 * step_mm) / step_mm));
        int next = min(k + leap, holds_end);
        if (next > k) {
          k = next;
          continue;
        }
      } else
#endif
      {
        vec3 index = index_at(k, origin, direction);
        vec4 classified = transfer_at(ct_hu(index));
        cost.x += 1.0;
        if (classified.a > 0.0) {
          // A whole cell is exactly one step long, whatever its place on the ray rounds to.
          bool whole = low >= begin && high <= end;
          float alpha =
              opacity_of(classified.a * (whole ? step_mm : min(high, end) - max(low, begin)));
#ifdef SHADING
          cost.y += 1.0;
          classified.rgb = shaded_sample(classified.rgb, index, axis_direction);
#endif
          put_behind(picture, classified.rgb, alpha);
          if (picture.a >= opaque_at) break;
        }
      }
    }
    if (high < end) {
      ++k;
      continue;
    }
#ifdef SURFACES
    if (surface.t >= kNever) break;
    put_behind(picture, surface.rgb, surface.alpha);
    if (surface.alpha >= 1.0 || picture.a >= opaque_at) break;
    begin = max(box.x, surface.t);
    surface = next_surface(ray, t_eye, surface.t, surface.order);
#ifdef SHARED_DEPTH
    if (surface.t >= t_stop) surface = kNoSurface;
#endif
    end = min(box.y, surface.t);
    k = int(floor(begin / step_mm));
#else
    break;
#endif
  }
  colour = picture;
}
