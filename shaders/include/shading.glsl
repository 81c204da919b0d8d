// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Shading of CT samples by the gradient. The gradient stays on the index axes, because only its
// length and its angles to the ray and to the light matter.

#ifdef GRADIENTS
uniform vec3 half_per_spacing;  // 1 / (2 * spacing), per mm.

#ifdef GRADIENT_TEXTURE
uniform sampler3D gradients;  // Differences of each voxel's neighbours, in the CT's format.
#endif

vec3 per_difference;  // A copy of half_per_spacing: taken_over.glsl.

// Central difference one voxel on either side, HU/mm.
vec3 gradient_at(vec3 index) {
#ifdef GRADIENT_TEXTURE
  return trilinear(gradients, index).rgb * per_difference;
#elif defined(VOXEL_PAIRS)
  return differences_at(index) * per_difference;
#else
  vec3 i = clamp(index, vec3(0.0), vec3(ct_size - 1));
  return vec3(ct_hu(i + vec3(1, 0, 0)) - ct_hu(i - vec3(1, 0, 0)),
              ct_hu(i + vec3(0, 1, 0)) - ct_hu(i - vec3(0, 1, 0)),
              ct_hu(i + vec3(0, 0, 1)) - ct_hu(i - vec3(0, 0, 1))) *
         per_difference;
#endif
}
#endif

#ifdef SHADING
uniform mat3 axes_from_local;  // Rotation (or mirror) to the index axes.
uniform float full_gradient_per_mm;
#ifdef PREINTEGRATED
uniform float shades_per_root;  // Shades per square root of the weight of one cell.
float shades_taken;
#endif
#ifdef EMPHASIS
uniform float emphasis;
#endif
vec3 ray_axes;  // The ray's direction along the index axes.
float full_gradient;  // A copy: taken_over.glsl.
#ifdef EMPHASIS
float emphasised;
#endif
#ifdef PHONG
vec4 light_of_shading;
#endif
#ifdef GOOCH
vec3 light_axes;
vec3 shares_of_gooch;
#endif

#ifdef GOOCH
uniform vec3 gooch_light;  // Unit, along the index axes.
uniform vec3 gooch_shares;  // Share of the own colour in cool and warm; darkening of silhouettes.

// towards_light: cosine, with the normal turned to the eye.
vec3 gooch(vec3 rgb, float cosine, float towards_light) {
  float warmth = 0.5 * (1.0 + clamp(towards_light, -1.0, 1.0));
  vec3 cool = rgb * shares_of_gooch.x + vec3(0.0, 0.0, kGoochBlue);
  vec3 warm = rgb * shares_of_gooch.y + vec3(kGoochYellow, kGoochYellow, 0.0);
  float edge = 1.0 - clamp(abs(cosine), 0.0, 1.0);
  float dark = 1.0 - shares_of_gooch.z * edge * edge * edge * edge;
  return clamp(dark * mix(cool, warm, warmth), 0.0, 1.0);
}
#endif

// share: the share of the shading that importance leaves, > 0.
vec3 shaded(vec3 rgb, vec3 gradient, float share) {
  float norm = length(gradient);
  if (!(norm > 0.0)) return rgb;
  float cosine = dot(gradient, ray_axes) / norm;
#ifdef GOOCH
  float lit = dot(gradient, light_axes) / norm;
  vec3 full = gooch(rgb, cosine, cosine > 0.0 ? -lit : lit);
#else
  vec3 full = phong(rgb, cosine, light_of_shading);
#endif
  return mix(rgb, full, share * min(1.0, norm / full_gradient));
}
#endif

#ifdef GRADIENTS
// Call it after set_lattice().
void take_over_shading() {
  per_difference = taken_over(half_per_spacing);
#ifdef SHADING
  ray_axes = axes_from_local * ray_direction;
  full_gradient = taken_over(full_gradient_per_mm);
#ifdef PREINTEGRATED
  shades_taken = taken_over(shades_per_root);
#endif
#ifdef EMPHASIS
  emphasised = taken_over(emphasis);
#endif
#ifdef PHONG
  light_of_shading = vec4(taken_over(shade_light.xyz), taken_over(shade_light.w));
#endif
#ifdef GOOCH
  light_axes = taken_over(gooch_light);
  shares_of_gooch = taken_over(gooch_shares);
#endif
#endif
}
#endif
