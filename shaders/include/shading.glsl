// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Blinn-Phong with a headlight: one cosine decides, two-sided. shade_light: ambient, diffuse,
// specular, shininess.

uniform vec4 shade_light;

vec3 shade(vec3 rgb, float cosine, float weight) {
  float c = clamp(abs(cosine), 0.0, 1.0);
  float lit = shade_light.x + shade_light.y * c;
  float gloss = shade_light.z * pow(max(c, 1.0e-20), shade_light.w);
  return mix(rgb, clamp(rgb * lit + gloss, 0.0, 1.0), weight);
}

#ifdef SHADING
uniform vec3 half_per_spacing;  // 1 / (2 * spacing), per mm.
uniform float full_gradient_per_mm;

// Colour of a CT sample. index: where; axis_direction: the ray along the index axes, unit. The
// gradient stays on the index axes: only its length and its angle to the ray matter.
vec3 shaded_sample(vec3 rgb, vec3 index, vec3 axis_direction) {
  vec3 gradient = vec3(ct_hu(index + vec3(1, 0, 0)) - ct_hu(index - vec3(1, 0, 0)),
                       ct_hu(index + vec3(0, 1, 0)) - ct_hu(index - vec3(0, 1, 0)),
                       ct_hu(index + vec3(0, 0, 1)) - ct_hu(index - vec3(0, 0, 1))) *
                  half_per_spacing;
  float norm = length(gradient);
  if (!(norm > 0.0)) return rgb;
  return shade(rgb, dot(gradient, axis_direction) / norm, min(1.0, norm / full_gradient_per_mm));
}
#endif
