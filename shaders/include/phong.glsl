// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Blinn-Phong with a headlight: one cosine decides, two-sided.

uniform vec4 shade_light;  // Ambient, diffuse, specular, shininess.

vec3 phong(vec3 rgb, float cosine) {
  float c = clamp(abs(cosine), 0.0, 1.0);
  float lit = shade_light.x + shade_light.y * c;
  // 0^0 is 1, as in C; GLSL leaves it open.
  float gloss = shade_light.w > 0.0 ? pow(max(c, 1.0e-20), shade_light.w) : 1.0;
  return clamp(rgb * lit + shade_light.z * gloss, 0.0, 1.0);
}
