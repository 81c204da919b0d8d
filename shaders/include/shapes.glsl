// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Solid shapes with a radius, lit by the headlight. Space: local mm.

// Where a ray enters a sphere; kNever when it misses. The discriminant comes from the distance of
// the centre to the ray, which does not cancel for a far origin.
float enter_sphere(vec3 centre, float radius, Ray ray) {
  vec3 m = centre - ray.origin;
  float along = dot(m, ray.direction);
  vec3 aside = m - along * ray.direction;
  float square = radius * radius - dot(aside, aside);
  return square < 0.0 ? kNever : along - sqrt(square);
}

#ifdef NEEDLE
uniform vec3 needle_a;  // Ends of the capsule's axis.
uniform vec3 needle_b;
uniform float needle_radius;
uniform vec4 needle_rgba;

float enter_needle(Ray ray) {
  vec3 axis = needle_b - needle_a;
  float axis_length = length(axis);
  if (!(axis_length > 0.0)) return enter_sphere(needle_a, needle_radius, ray);
  vec3 u = axis / axis_length;
  vec3 m = ray.origin - needle_a;
  vec3 across = ray.direction - dot(ray.direction, u) * u;
  vec3 start = m - dot(m, u) * u;
  float a = dot(across, across);
  if (a > 0.0) {
    float along = -dot(across, start) / a;
    vec3 nearest = start + along * across;
    float square = needle_radius * needle_radius - dot(nearest, nearest);
    if (square < 0.0) return kNever;
    float t = along - sqrt(square / a);
    float foot = dot(m + t * ray.direction, u);
    if (foot >= 0.0 && foot <= axis_length) return t;
  }
  return min(enter_sphere(needle_a, needle_radius, ray),
             enter_sphere(needle_b, needle_radius, ray));
}

Surface hit_needle(Ray ray, float t_eye) {
  float t = enter_needle(ray);
  if (!(t > t_eye && t < kNever)) return kNoSurface;
  vec3 p = ray.origin + t * ray.direction;
  vec3 axis = needle_b - needle_a;
  float square = dot(axis, axis);
  float foot = square > 0.0 ? clamp(dot(p - needle_a, axis) / square, 0.0, 1.0) : 0.0;
  vec3 normal = (p - needle_a - foot * axis) / needle_radius;
  return Surface(t, 1, shade(needle_rgba.rgb, dot(normal, ray.direction), 1.0), needle_rgba.a);
}
#endif

#ifdef SPHERES
uniform sampler2D spheres;  // Row i: (centre, radius) and (rgb, alpha).

Surface hit_sphere(int i, Ray ray, float t_eye) {
  vec4 shape = texelFetch(spheres, ivec2(0, i), 0);
  float t = enter_sphere(shape.xyz, shape.w, ray);
  if (!(t > t_eye && t < kNever)) return kNoSurface;
  vec4 rgba = texelFetch(spheres, ivec2(1, i), 0);
  vec3 normal = (ray.origin + t * ray.direction - shape.xyz) / shape.w;
  return Surface(t, 2 + i, shade(rgba.rgb, dot(normal, ray.direction), 1.0), rgba.a);
}
#endif
