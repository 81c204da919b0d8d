// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Blinn-Phong with a headlight: one cosine determines it, two-sided.

uniform vec4 shade_light;  // Ambient, diffuse, specular, shininess.

// light: like shade_light.
vec3 phong(vec3 rgb, float cosine, vec4 light) {
  float c = clamp(abs(cosine), 0.0, 1.0);
  float lit = light.x + light.y * c;
  // 0^0 is 1, as in C; GLSL leaves it undefined.
  float gloss = light.w > 0.0 ? pow(max(c, 1.0e-20), light.w) : 1.0;
  return clamp(rgb * lit + light.z * gloss, 0.0, 1.0);
}
