// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Rays through pixel centres. Space: local mm (CT axes, origin at voxel (0, 0, 0)).
// t: mm along the ray, counted from t_base_mm. That is a multiple of the step close to the volume,
// so that a far eye costs no digits of single precision. The eye is at t = -t_base_mm.

uniform vec3 base_local;   // eye + t_base_mm * forward, mm; summed in double.
uniform float t_base_mm;   // >= 0.
uniform vec3 right;        // Unit axes of the view.
uniform vec3 up;
uniform vec3 forward;
uniform float pixel_size;  // Perspective: size at distance 1, unitless. Orthographic: mm.
uniform vec2 image_size;  // In pixels.
uniform bool orthographic;

struct Ray {
  vec3 origin;     // At t = 0, local mm.
  vec3 direction;  // Unit.
};

Ray ray_of_pixel(vec2 centre) {  // centre: in pixels, row 0 at the bottom.
  vec2 ab = (centre - 0.5 * image_size) * pixel_size;
  vec3 offset = ab.x * right + ab.y * up;
  if (orthographic) return Ray(base_local + offset, forward);
  float square = dot(ab, ab);
  float norm = sqrt(1.0 + square);
  // t_base * ((forward + offset) / norm - forward), without cancellation.
  vec3 aside = (offset - forward * (square / (norm + 1.0))) / norm;
  return Ray(base_local + t_base_mm * aside, (forward + offset) / norm);
}
