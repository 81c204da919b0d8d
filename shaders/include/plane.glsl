// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The ultrasound plane, z = 0 of the Image frame, mm. Border: colour of the safety state, width as
// in render/spec/ray_spec_surfaces.hpp.

uniform vec2 us_size;                // In pixels; resolve.frag inserts the image itself.
uniform mat3 image_from_local;       // Rotation.
uniform vec3 image_origin;            // Origin of the Image frame, local mm.
uniform mat2 pixel_from_mm;
uniform vec2 grid_origin_mm;         // Position of pixel (0, 0).
uniform vec2 mm_across;              // Distance of neighbouring columns, rows; mm.
uniform bool has_outline;
uniform vec4 outline;                // Apex x, y; least and greatest radius; mm.
uniform vec2 outline_half;           // Sine and cosine of the half angle.
uniform bool shows_image;            // false when stale: border only.
uniform vec3 border_rgb;
uniform float plane_opacity;         // (0, 1].


// Distance to the nearest edge of the drawn area, mm; negative outside.
float depth_inside(vec2 p_image, vec2 pixel, vec2 size) {
  vec2 to_edge = min(pixel + 0.5, size - 0.5 - pixel) * mm_across;
  float inside = min(to_edge.x, to_edge.y);
  if (!has_outline) return inside;
  vec2 d = p_image - outline.xy;
  float radius = length(d);
  inside = min(inside, min(radius - outline.z, outline.w - radius));
  return min(inside, d.y * outline_half.x - abs(d.x) * outline_half.y);
}

// The points at which rays beside a ray meet the plane. If this ray meets it at p, the ray a pixels
// to the right and b pixels up meets it at p + (a * right + b * up) / w, w = 1 + dot(vec2(a, b),
// turn).
struct PlanePixel {
  vec2 right;  // In image mm.
  vec2 up;
  vec2 turn;  // 0: parallel rays.
};

// The pixel of the ray that meets the plane at t, mm from the eye. along: direction of the ray in
// the Image frame.
PlanePixel pixel_on_plane(Ray ray, vec3 along, float t) {
  float apart = orthographic ? pixel_size : pixel_size * t * dot(ray.direction, forward);
  vec3 to_right = apart * (image_from_local * right);
  vec3 to_up = apart * (image_from_local * up);
  vec2 sooner = vec2(to_right.z, to_up.z) / along.z;  // mm along the ray.
  return PlanePixel(to_right.xy - sooner.x * along.xy, to_up.xy - sooner.y * along.xy,
                    orthographic ? vec2(0.0) : sooner / t);
}

// True if a point at this distance inside, >= 0, is on the border: it is nearer to the edge than
// kBorderMm, or one of eight points kBorderPixels around it in the image lies outside.
bool on_border(vec2 p_image, float inside, PlanePixel next) {
  if (inside < kBorderMm) return true;
  float farthest = kBorderPixels * sqrt(dot(next.right, next.right) + dot(next.up, next.up));
  if (inside * (1.0 - kBorderPixels * length(next.turn)) > farthest) return false;
  for (int k = 0; k < 9; ++k) {
    vec2 way = vec2(k % 3 - 1, k / 3 - 1);
    vec2 to = way * (k % 2 == 0 ? kBorderPixels * sqrt(0.5) : kBorderPixels);
    float w = 1.0 + dot(to, next.turn);
    if (!(w > 0.0)) return true;
    vec2 q = p_image + (to.x * next.right + to.y * next.up) / w;
    if (!(depth_inside(q, pixel_from_mm * (q - grid_origin_mm), us_size) >= 0.0)) return true;
  }
  return false;
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
  if (on_border(p, inside, pixel_on_plane(ray, d, t - t_eye)))
    return Surface(t, 0, border_rgb, 1.0, false);
  if (!shows_image) return kNoSurface;
  return Surface(t, 0, vec3(pixel, 0.0), plane_opacity, true);
}
