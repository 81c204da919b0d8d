// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The contextual cutaway of render/spec/ray_spec_cutaway.hpp, for both angles at once (vec2:
// theta1, theta2). Objects are rows of a texture: texel 0 has the normal and the number of
// vertices, 0 for a ball; texels 1 and 2 have the axes of the plane; texel 3 has a ball around the
// object, or the ball itself; then come the vertices. Space: local mm. t is counted as for the ray,
// from close to the volume.

// Thresholds by importance: 1, 0, 0. Constant ones: 0, lower, upper.
uniform vec3 fade_by;
uniform float overlay_mm;   // Along the ray; very large: no clear region.

const int kFirstVertex = 4;
const float kNowhere = -3.0e38;

struct CutawaySpan {
  float t1;
  float t2;  // >= t1.
};

CutawaySpan cut_span;  // The span of the ray.

#ifdef CUT_FIELD
uniform sampler2D cut_field;  // theta2, theta1: t from the eye, row 0 at the top.
uniform int cut_field_height;

CutawaySpan meet_cutaway(Ray ray, float begin) {
  ivec2 at = ivec2(pixel_centre);
  vec2 t = texelFetch(cut_field, ivec2(at.x, cut_field_height - 1 - at.y), 0).rg - t_base_mm;
  return CutawaySpan(t.y, t.x);
}
#else
uniform sampler2D cut_objects;
uniform int cut_count;
uniform vec2 cut_cot;       // Cotangents of theta1, theta2.

vec2 cone_point(vec3 q, Ray ray) {
  vec3 m = q - ray.origin;
  float along = dot(m, ray.direction);
  return along - cut_cot * length(m - along * ray.direction);
}

vec2 cone_segment(vec3 a, vec3 b, Ray ray) {
  vec3 from = a - ray.origin;
  vec3 edge = b - a;
  float along_a = dot(from, ray.direction);
  vec3 across_a = from - along_a * ray.direction;
  float rise = dot(edge, ray.direction);
  vec3 across = edge - rise * ray.direction;
  float size = length(across);
  if (!(size > 1.0e-6)) return max(cone_point(a, ray), cone_point(b, ray));
  vec3 e = across / size;
  float foot = -dot(across_a, e);
  float height = length(across_a + foot * e);
  float slope = rise / size;
  vec2 room = max((cut_cot - slope) * (cut_cot + slope), 1.0e-30);
  vec2 s = clamp(foot + height * slope * inversesqrt(room), 0.0, size);
  s = mix(vec2(slope > 0.0 ? size : 0.0), s, lessThan(vec2(abs(slope)), cut_cot));
  return along_a + slope * s - cut_cot * sqrt((s - foot) * (s - foot) + height * height);
}

vec2 cone_ball(vec4 ball, Ray ray) {
  vec3 m = ball.xyz - ray.origin;
  float along = dot(m, ray.direction);
  float across = length(m - along * ray.direction);
  vec2 norm = sqrt(1.0 + cut_cot * cut_cot);
  vec2 beyond = vec2(along + sqrt(max(ball.w * ball.w - across * across, 0.0)));
  vec2 slanted = along - cut_cot * across + ball.w * norm;
  return mix(beyond, slanted, greaterThanEqual(vec2(across), ball.w * cut_cot / norm));
}

vec2 cone_polygon(int row, int count, vec3 normal, Ray ray) {
  vec3 axis_u = texelFetch(cut_objects, ivec2(1, row), 0).xyz;
  vec3 axis_v = texelFetch(cut_objects, ivec2(2, row), 0).xyz;
  vec3 first = texelFetch(cut_objects, ivec2(kFirstVertex, row), 0).xyz;
  float facing = dot(normal, ray.direction);
  float t = facing != 0.0 ? dot(normal, first - ray.origin) / facing : 0.0;
  vec3 p = ray.origin + t * ray.direction - first;
  vec2 at = vec2(dot(p, axis_u), dot(p, axis_v));
  vec3 from = texelFetch(cut_objects, ivec2(kFirstVertex + max(count, 1) - 1, row), 0).xyz;
  vec2 before = vec2(dot(from - first, axis_u), dot(from - first, axis_v));
  bool inside = false;
  vec2 best = vec2(kNowhere);
  for (int i = 0; i < count; ++i) {
    vec3 to = texelFetch(cut_objects, ivec2(kFirstVertex + i, row), 0).xyz;
    vec2 now = vec2(dot(to - first, axis_u), dot(to - first, axis_v));
    best = max(best, cone_segment(from, to, ray));
    bool crosses = (now.y > at.y) != (before.y > at.y);
    float u = (before.x - now.x) * (at.y - now.y) / (crosses ? before.y - now.y : 1.0) + now.x;
    if (crosses && at.x < u) inside = !inside;
    from = to;
    before = now;
  }
  if (count == 0) return best;
  float steep = length(normal - facing * ray.direction);
  bvec2 shallow = lessThanEqual(vec2(steep), cut_cot * abs(facing));
  return mix(best, vec2(t), bvec2(inside && facing != 0.0 && shallow.x,
                                  inside && facing != 0.0 && shallow.y));
}

// The t at which both surfaces meet a ray; kNowhere if they cannot lie behind begin. Either all
// objects are tested or none, because the theta1 of one object shapes the fade of the theta2 of
// another.
CutawaySpan meet_cutaway(Ray ray, float begin) {
  float farthest = kNowhere;
  for (int row = 0; row < cut_count; ++row)
    farthest = max(farthest, cone_ball(texelFetch(cut_objects, ivec2(3, row), 0), ray).y);
  int count = farthest > begin ? cut_count : 0;
  vec2 best = vec2(kNowhere);
  for (int row = 0; row < count; ++row) {
    vec2 bound = cone_ball(texelFetch(cut_objects, ivec2(3, row), 0), ray);
    vec4 head = texelFetch(cut_objects, ivec2(0, row), 0);
    int vertices = any(greaterThan(bound, best)) ? int(head.w) : 0;
    best = max(best, head.w > 0.0 ? cone_polygon(row, vertices, head.xyz, ray) : bound);
  }
  return CutawaySpan(best.x, max(best.x, best.y));
}
#endif

// Omega at t.
float occlusion(CutawaySpan span, float t) {
  if (!(t < span.t2)) return 0.0;
  float transition = span.t2 - span.t1;
  float outer = transition > 0.0 ? clamp((span.t2 - t) / transition, 0.0, 1.0) : 1.0;
  float into = span.t1 - t;
  float inner = into > 0.0 ? (overlay_mm > 0.0 ? min(into / overlay_mm, 1.0) : 1.0) : 0.0;
  return 0.5 * (outer + inner);
}

// The share of its opacity that a sample keeps.
float visibility(float importance, float omega) {
  float low = fma(max(2.0 * importance - 1.0, 0.0), fade_by.x, fade_by.y);
  float high = fma(importance, fade_by.x, fade_by.z);
  if (omega <= low) return 1.0;
  if (omega >= high) return 0.0;
  return (high - omega) / (high - low);
}

// Extinction after the opacity of 1 mm was faded.
float faded(float tau, float visible) {
  float z = min(visible * opacity_of(tau), 0.99999994);
  float series =
      z * (1.0 + z * (0.5 + z * (1.0 / 3.0 + z * (0.25 + z * (0.2 + z * (1.0 / 6.0))))));
  float rest = z < 0.1 ? series : -log(1.0 - z);
  return visible >= 1.0 ? tau : (visible > 0.0 ? rest : 0.0);
}

// Up to this t nothing of this importance, < 1, is visible. The margin makes this certain despite
// rounding.
float hidden_until(CutawaySpan span, float importance) {
  const float kMarginMm = 0.01;
  if (fade_by.x == 0.0) return kNowhere;  // Constant thresholds hide by no importance.
  float t = importance <= 0.5 ? span.t2 - 2.0 * importance * (span.t2 - span.t1)
                              : span.t1 - (2.0 * importance - 1.0) * overlay_mm;
  return t - kMarginMm;
}
