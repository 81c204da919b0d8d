#version 410 core
// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Casts one ray per pixel through a CT as in raycast.frag and through an ultrasound volume as in
// predicates.frag, composited by importance: render/spec/ray_spec.hpp, "Two volumes". Results as in
// predicates.frag.

#include "include/camera.glsl"
#include "include/targets.glsl"
#define pixel_centre fragment_centre
#include "include/taken_over.glsl"
#include "include/ct.glsl"
#include "include/compositing.glsl"
#include "include/lattice.glsl"
#include "include/lattice_phase.glsl"
#if defined(PHONG) || defined(SOLIDS) || defined(PREDICATE_SHADING)
#include "include/phong.glsl"
#endif
#ifdef SHARED_DEPTH
#include "include/shared_depth.glsl"
#endif
#ifdef SKIPPING
#include "include/bricks.glsl"
#endif
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

uniform float opaque_at;  // A stretch of the CT ends at this alpha; > 1: never.

vec4 layer;  // The stretch of the CT that is being composited, premultiplied.
float enough;  // The alpha of the stretch at which it ends.
#ifdef PREINTEGRATED
int bow_from;  // The first cell with a bow.
#endif
#include "include/march.glsl"

#ifdef PREINTEGRATED
#define PREINTEGRATED_CT
#undef PREINTEGRATED
#endif
#undef VOXEL_PAIRS  // The second volume is a texture.
#include "include/second_names.glsl"
#include again "include/ct.glsl"
#include again "include/lattice.glsl"
#include again "include/lattice_phase.glsl"
#include again "include/bricks.glsl"
#ifdef GENERIC
#include "include/predicate_generic.glsl"
#endif
#include "include/predicate_appearance.glsl"
#include "include/predicate_light.glsl"
#ifdef PREDICATE_SHADING
#include "include/predicate_shading.glsl"
#endif
#include "include/predicate_march.glsl"
#include "include/second_names_end.glsl"

#include "include/slabs.glsl"
#if defined(PLANE) || defined(SOLIDS)
#define SURFACES
#include "include/next_surface.glsl"
#endif
#ifdef SIGNATURE
#include "include/signature.glsl"
#endif

uniform vec3 second_base_local;  // base_local of the ultrasound.
uniform float ct_importance;     // In the unit of the light.
uniform float ray_ends_at;       // A ray ends when this share of its colour is final; > 1: never.

// Composites the part of the CT between two positions, in cells, as one sample.
void add_ct(float first, float last) {
  if (!(last > first) || last <= clear_to) return;
  layer = vec4(0.0);
  enough = taken_over(opaque_at);
#ifdef CUTAWAY
  march_cut(first, last);
#else
  march(first, last, false);
#endif
  if (layer.a > 0.0) blend(layer.rgb / layer.a, layer.a, ct_importance, 0.0);
}

void add_ultrasound(float first, float last) {
  if (!(last > first) || last <= second_clear_to) return;
  ended = false;
  greatest_to_come = surface_importance;
#ifdef CUTAWAY
  second_march_cut(first, last);
#else
  second_march(first, last, last, false);
#endif
}

// True if nothing that follows can be visible.
bool is_final() { return light.alpha * kept_before(surface_importance) >= ray_ends_at; }

vec2 ct_cells(Slabs s, int n) {
  vec2 part = stretch_of(s, n, s.ct);
  return vec2(whole_cells(cells_of(part.x)), whole_cells(cells_of(part.y)));
}

vec2 ultrasound_cells(Slabs s, int n) {
  vec2 part = stretch_of(s, n, s.ultrasound);
  return vec2(whole_cells(second_cells_of(part.x)), whole_cells(second_cells_of(part.y)));
}

// True if a part of a stretch may be visible.
bool shows_ct(Slabs s, int n) {
  vec2 part = ct_cells(s, n);
  return part.y > part.x && part.y > clear_to;
}

bool shows_ultrasound(Slabs s, int n) {
  vec2 part = ultrasound_cells(s, n);
  return part.y > part.x && part.y > second_clear_to;
}

int next_turn(Slabs s, int n) {
  return turn_after(s, n, min(t_of(clear_to), second_t_of(second_clear_to)));
}

// Marches through both volumes in front of the next surface.
void march_slabs(Slabs s) {
  int n = first_turn(s);
  int last = last_turn(s);
  bool open;
  do {
    // Either volume continues alone while the other shows nothing. Each has its own loop, because
    // devices that run many rays in step can skip nothing else.
    bool alone;
    do {
      vec2 part = ct_cells(s, n);
      add_ct(part.x, part.y);
      alone = !shows_ultrasound(s, n + 1);
      if (alone) n = next_turn(s, n);
      open = n <= last && !is_final();
    } while (alone && open);
    if (open) do {
      vec2 part = ultrasound_cells(s, n + 1);
      add_ultrasound(part.x, part.y);
      n = next_turn(s, n);
      open = n <= last && !is_final();
    } while (open && !shows_ct(s, n));
  } while (open);
}

// ct_box, ultrasound_box: the parts of the ray in the volumes, t.
void cast_ray(Ray ray, float t_eye, float t_stop, vec2 ct_box, vec2 ultrasound_box) {
  begin_light();
  clear_to = second_clear_to = -1.0e9;
#ifdef PREINTEGRATED_CT
  forget();
  bow_from = int(floor(cells_of(ct_box.x))) + 2;
#endif
#ifdef PLANE
  live_at = vec2(-1.0e9);
#endif
#ifdef SURFACES
  // Everything up to the first opaque surface, because nothing behind it can outshine it.
  float begin = t_eye;
  Surface surface = next_surface(ray, t_eye, t_stop, t_eye, -1);
  for (;;) {
    march_slabs(slabs_between(begin, surface.t, ct_box, ultrasound_box));
    if (surface.t >= kNever || is_final()) break;
    if (surface.live) {
#ifdef PLANE
      live_at = surface.rgb.xy;
#endif
      blend(vec3(0.0), surface.alpha, surface_importance, 1.0);
    } else {
      blend(surface.rgb, surface.alpha, surface_importance, 0.0);
    }
    if (light.alpha >= 1.0) break;
    begin = surface.t;
    surface = next_surface(ray, t_eye, t_stop, surface.t, surface.order);
  }
#else
  march_slabs(slabs_between(t_eye, 3.0e38, ct_box, ultrasound_box));
#endif
  spent = vec4(cost.xyz + second_cost.xyz, cost.w);
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
  Ray second = Ray(second_base_local + (ray.origin - base_local), ray.direction);
  set_lattice(ray);
  move_lattice();
  second_set_lattice(second);
  second_move_lattice();
#if defined(SKIPPING) && !defined(PROJECTION)
  take_over_skipping();
#elif defined(SKIPPING)
  take_over_bricks();
#endif
  take_over_transfer();
#ifdef GRADIENTS
  take_over_shading();
#endif
#ifdef PREINTEGRATED_CT
  take_over_integrals();
#endif
  second_take_over_bricks();
  take_over_predicates();
  float t_eye = -t_base_mm;
  vec2 ct_box = clip_to_box(index_from_local * ray.origin, index_from_local * ray.direction, t_eye);
  vec2 ultrasound_box = second_clip_to_box(second_index_from_local * second.origin,
                                           second_index_from_local * second.direction, t_eye);
  float t_stop = 3.0e38;
#ifdef SHARED_DEPTH
  t_stop = t_of_geometry(ivec2(fragment_centre), ray.direction);
  ct_box.y = min(ct_box.y, t_stop);
  ultrasound_box.y = min(ultrasound_box.y, t_stop);
#endif
#ifdef CUTAWAY
  bool meets_ct = ct_box.y > ct_box.x;
  bool meets_ultrasound = ultrasound_box.y > ultrasound_box.x;
  float enters = min(meets_ct ? ct_box.x : 3.0e38, meets_ultrasound ? ultrasound_box.x : 3.0e38);
  cut_span = meet_cutaway(ray, enters);
  bool cut = cut_span.t2 > enters;
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
    cast_ray(ray, t_eye, t_stop, ct_box, ultrasound_box);
  }
#else
  cast_ray(ray, t_eye, t_stop, ct_box, ultrasound_box);
#endif
#ifdef COMPUTE
  write_fragment();
#endif
}
