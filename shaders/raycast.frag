#version 410 core
// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Casts one ray per pixel through the CT, the ultrasound plane and the solid shapes. The equations
// and the global lattice of cells are those of render/spec/ray_spec.hpp, which the reference engine
// runs in double. Features that a scene does not use are not compiled: see GlFeatures.
// Results: premultiplied colour and alpha in [0, 1], up to the ultrasound image if the ray meets
// it; the cost; and with PLANE the layer behind the ultrasound image, and the column and row at
// which the ray meets it. resolve.frag puts the ultrasound image between the two layers.

#include "include/camera.glsl"
#include "include/targets.glsl"
#ifdef SPARSE
#include "include/sparse.glsl"
#else
#define pixel_centre fragment_centre
#endif
#include "include/taken_over.glsl"
#include "include/ct.glsl"
#include "include/compositing.glsl"
#include "include/lattice.glsl"
#if defined(PHONG) || defined(SOLIDS)
#include "include/phong.glsl"
#endif
#ifdef SHARED_DEPTH
#include "include/shared_depth.glsl"
#endif
#ifdef SKIPPING
#include "include/bricks.glsl"
#endif
#ifdef PROJECTION
#include "include/projection.glsl"
#else
#include "include/transfer.glsl"
#include "include/shading.glsl"
#ifdef PREINTEGRATED
#include "include/preintegrated.glsl"
#endif
#ifdef CUTAWAY
#include "include/cutaway.glsl"
#endif
#ifdef SKIPPING
#include "include/skipping.glsl"
#endif
#endif

uniform float opaque_at;  // The ray ends at this alpha; > 1: never.

vec4 layer;  // The layer that is being composited, premultiplied.
float enough;  // The alpha of the layer at which the ray ends.
#ifdef PREINTEGRATED
int bow_from;  // The first cell with a bow.
#endif

#ifndef PROJECTION
#include "include/march.glsl"
#endif

#if defined(PLANE) || defined(SOLIDS)
#define SURFACES
#include "include/next_surface.glsl"
#endif
#ifdef SIGNATURE
#include "include/signature.glsl"
#endif

// Marches through the volume between two positions on the ray, mm.
void march_between(float begin, float end) {
#ifndef PROJECTION
  float first = cells_of(begin);
  float last = cells_of(end);
#ifdef CUTAWAY
  march_cut(first, last);
#else
  march(first, last, false);
#endif
#endif
}

#ifdef SURFACES
#ifdef PLANE
vec4 front;
bool split = false;

// Ends the layer in front of the ultrasound image. The alpha at which the layer behind it ends
// depends on how much that layer can show. Returns false if it can show nothing.
bool begin_behind(Surface surface) {
  front = layer;
  live_at = surface.rgb.xy;
  split = true;
  float total = front.a + (1.0 - front.a) * surface.alpha;
  float left = (1.0 - front.a) * (1.0 - surface.alpha);
  layer = vec4(0.0);
  if (!(left > 0.0) || total >= opaque_at) return false;
  enough = (opaque_at - total) / left;
  return true;
}
#endif

// Everything up to the first opaque surface. Returns true if the ray goes on behind the last
// surface.
bool cast_surfaces(Ray ray, float t_eye, float t_stop, vec2 box) {
  float begin = box.x;
  Surface surface = next_surface(ray, t_eye, t_stop, t_eye, -1);
  for (;;) {
    march_between(begin, min(box.y, surface.t));
    if (layer.a >= enough) return false;
    if (surface.t >= kNever) return true;
#ifdef PLANE
    if (surface.live) {
      if (!begin_behind(surface)) return false;
    } else
#endif
    {
      put_behind(layer, surface.rgb, surface.alpha);
      if (surface.alpha >= 1.0 || layer.a >= enough) return false;
    }
    begin = max(box.x, surface.t);
    surface = next_surface(ray, t_eye, t_stop, surface.t, surface.order);
  }
}
#endif

// box: the part of the ray in the volume, t.
void cast_ray(Ray ray, float t_eye, float t_stop, vec2 box) {
  layer = vec4(0.0);
  enough = taken_over(opaque_at);
#ifdef PREINTEGRATED
  bow_from = int(floor(cells_of(box.x))) + 2;
#endif
#ifdef PLANE
  live_at = vec2(-1.0e9);
#endif
#ifdef SURFACES
  bool open = cast_surfaces(ray, t_eye, t_stop, box);
#else
  march_between(box.x, box.y);
  bool open = true;
#endif
#ifdef PROJECTION
  if (open && box.y > box.x)
    put_behind(layer, vec3(projected_grey(cells_of(box.x), cells_of(box.y))), 1.0);
#endif
  spent = cost;
#ifdef PLANE
  colour = split ? front : layer;
  behind = split ? layer : vec4(0.0);
#else
  colour = closed(layer, opaque_at);
#endif
}

void main() {
#ifdef COMPUTE
  if (!begin_fragment()) return;
#endif
#ifdef SPARSE
  set_pixel();
#endif
  Ray ray = ray_of_pixel(pixel_centre);
  set_lattice(ray);
#if defined(SKIPPING) && !defined(PROJECTION)
  take_over_skipping();
#elif defined(SKIPPING)
  take_over_bricks();
#endif
#ifndef PROJECTION
  take_over_transfer();
#ifdef GRADIENTS
  take_over_shading();
#endif
#ifdef PREINTEGRATED
  take_over_integrals();
#endif
#endif
  float t_eye = -t_base_mm;
  vec2 box = clip_to_box(index_from_local * ray.origin, index_from_local * ray.direction, t_eye);
  float t_stop = 3.0e38;
#ifdef SHARED_DEPTH
  t_stop = t_of_geometry(ivec2(pixel_centre), ray.direction);
  box.y = min(box.y, t_stop);
#endif
#ifdef CUTAWAY
  cut_span = meet_cutaway(ray, box.y > box.x ? box.x : 3.0e38);
  bool cut = box.y > box.x && cut_span.t2 > box.x;
  if (cut) cost.w = 2.0;
#else
  const bool cut = false;
#endif
#ifdef SIGNATURE
  signature = signature_of(ray, t_eye, cut);
  if (is_kept(signature)) {
#ifdef COMPUTE
    return;
#else
    discard;
#endif
  } else {
    cast_ray(ray, t_eye, t_stop, box);
  }
#else
  cast_ray(ray, t_eye, t_stop, box);
#endif
#ifdef COMPUTE
  write_fragment();
#endif
}
