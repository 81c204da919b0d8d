#version 410 core
// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Fewer rays than pixels, by the rule of render/quality/sparse_rays.hpp. Copies the pixels of the
// pass before, interpolates others from them, and leaves the other fragments to raycast.frag by
// their depth. Results as in raycast.frag.

#include "include/camera.glsl"
#include "include/targets.glsl"
#include "include/sparse.glsl"
#include "include/taken_over.glsl"
#include "include/ct.glsl"
#include "include/compositing.glsl"
#include "include/lattice.glsl"
#ifdef SOLIDS
#include "include/phong.glsl"
#endif
#if defined(PLANE) || defined(SOLIDS)
#include "include/next_surface.glsl"
#endif
#ifdef SHARED_DEPTH
#include "include/shared_depth.glsl"
#endif

uniform int coarse_step;        // Pixels between fragments of the pass before.
uniform ivec2 last_of_lattice;  // Last column and row. Every pixel beyond has a ray.
uniform float pixel_error;
uniform float opaque_at;         // See raycast.frag.
uniform vec3 background_rgb;
uniform sampler2D coarse_front;  // Results of the pass before.
uniform sampler2D coarse_spent;
#ifdef PLANE
uniform sampler2D coarse_behind;
uniform sampler2D coarse_live_at;
#endif

// The colour around the ultrasound image, and the weight of that image, as the CPU engine keeps
// them.
vec4 compared_at(ivec2 at) {
  vec4 layers = texelFetch(coarse_front, at, 0);
  float weight = 0.0;
#ifdef PLANE
  if (texelFetch(coarse_live_at, at, 0).x > -1.0e6) {
    weight = (1.0 - layers.a) * plane_opacity;
    layers.a += weight;
    layers += (1.0 - layers.a) * texelFetch(coarse_behind, at, 0);
  }
#endif
  if (layers.a >= opaque_at) return vec4(layers.rgb, weight) / layers.a;
  return vec4(layers.rgb + (1.0 - layers.a) * background_rgb, weight);
}

// Tests the square whose upper left corner is that texel.
bool is_even(ivec2 at) {
  vec4 low = vec4(1.0e9);
  vec4 high = vec4(-1.0e9);
  for (int i = 0; i < 4; ++i) {
    vec4 corner = compared_at(at + ivec2(i & 1, i >> 1));
    low = min(low, corner);
    high = max(high, corner);
  }
  return all(lessThanEqual(high - low, vec4(pixel_error))) && (low.a > 0.0) == (high.a > 0.0);
}

// Squares outside the lattice decide nothing.
bool both_even(ivec2 first, ivec2 second, bool has_first, bool has_second) {
  return (has_first || has_second) && (!has_first || is_even(first)) &&
         (!has_second || is_even(second));
}

// Tests the squares around a pixel. at: texel of the corner at its upper left. rest: offset of the
// pixel from it.
bool is_even_around(ivec2 at, ivec2 rest) {
  if (rest.x == 0)
    return both_even(at - ivec2(1, 0), at, pixel.x > 0, pixel.x < last_of_lattice.x);
  if (rest.y == 0)
    return both_even(at - ivec2(0, 1), at, pixel.y > 0, pixel.y < last_of_lattice.y);
  return is_even(at);
}

// The mean of the two or four corners around the pixel, or of the one corner that it is.
vec4 mean_of(sampler2D layer, ivec2 at, ivec2 rest) {
  ivec2 other = at + ivec2(notEqual(rest, ivec2(0)));
  vec4 ends = texelFetch(layer, at, 0) + texelFetch(layer, other, 0);
  if (rest.x == 0 || rest.y == 0) return 0.5 * ends;
  vec4 others =
      texelFetch(layer, ivec2(at.x, other.y), 0) + texelFetch(layer, ivec2(other.x, at.y), 0);
  return 0.25 * (ends + others);
}

// True if a needle, sphere or line or the border of the ultrasound image may be visible there, or
// if geometry of others ends the ray.
bool meets_shapes() {
  bool meets = false;
#if defined(PLANE) || defined(SOLIDS) || defined(SHARED_DEPTH)
  Ray ray = ray_of_pixel(pixel_centre);
  float t_eye = -t_base_mm;
#endif
#ifdef PLANE
  Surface plane = hit_plane(ray, t_eye);
  meets = plane.t < kNever && !plane.live;
#endif
#ifdef SOLIDS
  for (int i = 0; i < solid_count; ++i) meets = meets || hit_solid(i, ray, t_eye).t < kNever;
#endif
#ifdef SHARED_DEPTH
  vec2 box = clip_to_box(index_from_local * ray.origin, index_from_local * ray.direction, t_eye);
  meets = meets || t_of_geometry(ivec2(pixel_centre), ray.direction) < box.y;
#endif
  return meets;
}

void main() {
  set_pixel();
  ivec2 at = pixel / coarse_step;
  ivec2 rest = pixel - at * coarse_step;
  bool drawn = rest == ivec2(0);
  bool beyond = any(greaterThan(pixel, last_of_lattice));
  if (!drawn && (beyond || !is_even_around(at, rest) || meets_shapes())) {
    gl_FragDepth = 1.0;
    return;
  }
  gl_FragDepth = 0.0;
  colour = mean_of(coarse_front, at, rest);
  spent = drawn ? texelFetch(coarse_spent, at, 0) : vec4(0.0);
#ifdef PLANE
  behind = mean_of(coarse_behind, at, rest);
  live_at = mean_of(coarse_live_at, at, rest).xy;
#endif
}
