// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The ultrasound plane, z = 0 of the image frame, mm. Border: the safety state's colour.

uniform vec2 us_size;                // Pixels; the picture itself is put in by resolve.frag.
uniform mat3 image_from_local;       // Rotation.
uniform vec3 image_origin;            // Of the image frame, local mm.
uniform mat2 pixel_from_mm;
uniform vec2 grid_origin_mm;         // Of pixel (0, 0).
uniform vec2 mm_across;              // Distance of neighbouring columns, rows; mm.
uniform bool has_outline;
uniform vec4 outline;                // Apex x, y; least and greatest radius; mm.
uniform vec2 outline_half;           // Sine and cosine of the half angle.
uniform bool shows_picture;          // False when stale: border only.
uniform vec3 border_rgb;
uniform float plane_opacity;         // (0, 1].


// Distance to the nearest edge of what is drawn, mm; negative outside.
float depth_inside(vec2 p_image, vec2 pixel, vec2 size) {
  vec2 to_edge = min(pixel + 0.5, size - 0.5 - pixel) * mm_across;
  float inside = min(to_edge.x, to_edge.y);
  if (!has_outline) return inside;
  vec2 d = p_image - outline.xy;
  float radius = length(d);
  inside = min(inside, min(radius - outline.z, outline.w - radius));
  return min(inside, d.y * outline_half.x - abs(d.x) * outline_half.y);
}

Surface hit_plane(Ray ray, float t_eye) {
  vec3 o = image_from_local * (ray.origin - image_origin);
  vec3 d = image_from_local * ray.direction;
  if (abs(d.z) < kEdgeOnSine) return kNoSurface;
  float t = -o.z / d.z;
  if (!(t > t_eye)) return kNoSurface;
  vec2 p = o.xy + t * d.xy;
  vec2 pixel = pixel_from_mm * (p - grid_origin_mm);
  float inside = depth_inside(p, pixel, us_size);
  if (!(inside >= 0.0)) return kNoSurface;
  if (inside < kBorderMm) return Surface(t, 0, border_rgb, 1.0, false);
  if (!shows_picture) return kNoSurface;
  return Surface(t, 0, vec3(pixel, 0.0), plane_opacity, true);
}
