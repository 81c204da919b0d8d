#version 410 core
// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Casts one ray per pixel through an ultrasound volume classified by predicates, the ultrasound
// plane and the solid shapes. The equations are those of render/predicates/predicate_scene.hpp and
// render/spec/predicate_spec.hpp; the lattice of cells is that of render/spec/ray_spec.hpp. The
// predicates come before this text, see render/predicates/shader.hpp, or with GENERIC from a table.
// Results: colour and alpha in [0, 1], premultiplied, without the ultrasound image; the cost; and
// with PLANE the weight of the ultrasound image in the colour, and the column and row at which the
// ray meets it. resolve.frag inserts the ultrasound image.

#include "include/camera.glsl"
#include "include/targets.glsl"
#define pixel_centre fragment_centre
#include "include/taken_over.glsl"
#include "include/ct.glsl"
#include "include/compositing.glsl"
#include "include/lattice.glsl"
#if defined(SOLIDS) || defined(PREDICATE_SHADING)
#include "include/phong.glsl"
#endif
#ifdef SHARED_DEPTH
#include "include/shared_depth.glsl"
#endif
#ifdef CUTAWAY
#include "include/cutaway.glsl"
#endif
#include "include/bricks.glsl"
#ifdef GENERIC
#include "include/predicate_generic.glsl"
#endif
#include "include/predicate_appearance.glsl"
#include "include/predicate_light.glsl"
#ifdef PREDICATE_SHADING
#include "include/predicate_shading.glsl"
#endif
#include "include/predicate_march.glsl"
#if defined(PLANE) || defined(SOLIDS)
#define SURFACES
#include "include/next_surface.glsl"
#endif
#ifdef SIGNATURE
#include "include/signature.glsl"
#endif

// Marches through the volume between two positions on the ray, mm.
void march_between(float begin, float end) {
  float first = cells_of(begin);
  float last = cells_of(end);
  if (!(last > first)) return;
  ended = false;
  greatest_to_come = surface_importance;
#ifdef CUTAWAY
  march_cut(first, last);
#else
  march(first, last, last, false);
#endif
}

// box: the part of the ray in the volume, t.
void cast_ray(Ray ray, float t_eye, float t_stop, vec2 box) {
  begin_light();
#ifdef PLANE
  live_at = vec2(-1.0e9);
#endif
  float begin = box.x;
#ifdef SURFACES
  // Everything up to the first opaque surface, because nothing behind it can outshine it.
  Surface surface = next_surface(ray, t_eye, t_stop, t_eye, -1);
  for (;;) {
    march_between(begin, min(box.y, surface.t));
    if (surface.t >= kNever) break;
    if (surface.live) {
#ifdef PLANE
      live_at = surface.rgb.xy;
#endif
      blend(vec3(0.0), surface.alpha, surface_importance, 1.0);
    } else {
      blend(surface.rgb, surface.alpha, surface_importance, 0.0);
    }
    if (light.alpha >= 1.0) break;
    begin = max(box.x, surface.t);
    surface = next_surface(ray, t_eye, t_stop, surface.t, surface.order);
  }
#else
  march_between(begin, box.y);
#endif
  spent = cost;
  colour = vec4(light.alpha * light.rgb, light.alpha);
#ifdef PLANE
  behind = vec4(light.alpha * light.image, 0.0, 0.0, 0.0);
#endif
}

void main() {
#ifdef COMPUTE
  if (!begin_fragment()) return;
#endif
  Ray ray = ray_of_pixel(fragment_centre);
  set_lattice(ray);
  take_over_bricks();
  take_over_predicates();
  float t_eye = -t_base_mm;
  vec2 box = clip_to_box(index_from_local * ray.origin, index_from_local * ray.direction, t_eye);
  float t_stop = 3.0e38;
#ifdef SHARED_DEPTH
  t_stop = t_of_geometry(ivec2(fragment_centre), ray.direction);
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
