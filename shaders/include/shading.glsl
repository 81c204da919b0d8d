// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Shading of CT samples on the gradient, which stays on the index axes: only its length and its
// angles to the ray and to the light matter.

#ifdef GRADIENTS
uniform vec3 half_per_spacing;  // 1 / (2 * spacing), per mm.

#ifdef GRADIENT_TEXTURE
uniform sampler3D gradients;  // Differences of the neighbours of every voxel, as the CT.
#endif

// Central difference one voxel either way, HU/mm.
vec3 gradient_at(vec3 index) {
#ifdef GRADIENT_TEXTURE
  return trilinear(gradients, index).rgb * half_per_spacing;
#else
  vec3 i = clamp(index, vec3(0.0), vec3(ct_size - 1));
  return vec3(ct_hu(i + vec3(1, 0, 0)) - ct_hu(i - vec3(1, 0, 0)),
              ct_hu(i + vec3(0, 1, 0)) - ct_hu(i - vec3(0, 1, 0)),
              ct_hu(i + vec3(0, 0, 1)) - ct_hu(i - vec3(0, 0, 1))) *
         half_per_spacing;
#endif
}
#endif

#ifdef SHADING
uniform mat3 axes_from_local;  // Rotation (or mirror) to the index axes.
uniform float full_gradient_per_mm;
#ifdef EMPHASIS
uniform float emphasis;
#endif
#ifdef GOOCH
uniform vec3 gooch_light;  // Unit, along the index axes.
uniform vec3 gooch_shares;  // Of the own colour in cool and warm; darkening of silhouettes.

// towards_light: cosine, the normal turned to the eye.
vec3 gooch(vec3 rgb, float cosine, float towards_light) {
  float warmth = 0.5 * (1.0 + clamp(towards_light, -1.0, 1.0));
  vec3 cool = rgb * gooch_shares.x + vec3(0.0, 0.0, kGoochBlue);
  vec3 warm = rgb * gooch_shares.y + vec3(kGoochYellow, kGoochYellow, 0.0);
  float edge = 1.0 - clamp(abs(cosine), 0.0, 1.0);
  float dark = 1.0 - gooch_shares.z * edge * edge * edge * edge;
  return clamp(dark * mix(cool, warm, warmth), 0.0, 1.0);
}
#endif

// share: what importance leaves of the shading, > 0.
vec3 shaded(vec3 rgb, vec3 gradient, float share) {
  float norm = length(gradient);
  if (!(norm > 0.0)) return rgb;
  float cosine = dot(gradient, axes_from_local * ray_direction) / norm;
#ifdef GOOCH
  float lit = dot(gradient, gooch_light) / norm;
  vec3 full = gooch(rgb, cosine, cosine > 0.0 ? -lit : lit);
#else
  vec3 full = phong(rgb, cosine);
#endif
  return mix(rgb, full, share * min(1.0, norm / full_gradient_per_mm));
}
#endif
