// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Needle, spheres and lines, in this order. All are capsules, lit by the headlight; the axis of a
// sphere has no length. Space: local mm.

uniform sampler2D solids;  // Row i: (a, radius), (b, 0), (rgb, alpha).
uniform int solid_count;

// The t at which a ray enters a sphere; kNever if it misses. The discriminant comes from the
// distance of the centre from the ray, which does not cancel for a far origin.
float enter_sphere(vec3 centre, float radius, Ray ray) {
  vec3 m = centre - ray.origin;
  float along = dot(m, ray.direction);
  vec3 aside = m - along * ray.direction;
  float square = radius * radius - dot(aside, aside);
  return square < 0.0 ? kNever : along - sqrt(square);
}

#ifdef CAPSULES
float enter_capsule(vec3 a_end, vec3 b_end, float radius, Ray ray) {
  vec3 axis = b_end - a_end;
  float axis_length = length(axis);
  if (!(axis_length > 0.0)) return enter_sphere(a_end, radius, ray);
  vec3 u = axis / axis_length;
  vec3 m = ray.origin - a_end;
  vec3 across = ray.direction - dot(ray.direction, u) * u;
  vec3 start = m - dot(m, u) * u;
  float a = dot(across, across);
  if (a > 0.0) {
    float along = -dot(across, start) / a;
    vec3 nearest = start + along * across;
    float square = radius * radius - dot(nearest, nearest);
    if (square < 0.0) return kNever;
    float t = along - sqrt(square / a);
    float foot = dot(m + t * ray.direction, u);
    if (foot >= 0.0 && foot <= axis_length) return t;
  }
  return min(enter_sphere(a_end, radius, ray), enter_sphere(b_end, radius, ray));
}
#endif

Surface hit_solid(int i, Ray ray, float t_eye) {
  vec4 a = texelFetch(solids, ivec2(0, i), 0);
#ifdef CAPSULES
  vec3 b = texelFetch(solids, ivec2(1, i), 0).xyz;
  float t = enter_capsule(a.xyz, b, a.w, ray);
#else
  float t = enter_sphere(a.xyz, a.w, ray);
#endif
  if (!(t > t_eye && t < kNever)) return kNoSurface;
  vec4 rgba = texelFetch(solids, ivec2(2, i), 0);
  vec3 p = ray.origin + t * ray.direction - a.xyz;
#ifdef CAPSULES
  vec3 axis = b - a.xyz;
  float square = dot(axis, axis);
  p -= (square > 0.0 ? clamp(dot(p, axis) / square, 0.0, 1.0) : 0.0) * axis;
#endif
  return Surface(t, 1 + i, phong(rgba.rgb, dot(p, ray.direction) / a.w, shade_light), rgba.a, false);
}
