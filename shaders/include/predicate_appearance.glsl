// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The appearance of samples, from the predicates that are true for them:
// render/spec/predicate_spec.hpp, Eqs. 6 to 8.

struct Appearance {
  vec3 tint;         // Times the chroma; added to the grey of the intensity.
  float importance;  // In the unit of the light; <= 0: invisible.
};

#ifdef APPEARANCE_TABLE
// Tint and importance, one texel for each class of samples.
#ifdef STORAGE
layout(std430, binding = 1) readonly buffer Appearances { vec4 appearances[]; };
#define appearance_texel(i) appearances[i]
#else
uniform samplerBuffer appearances;
#define appearance_texel(i) texelFetch(appearances, i)
#endif

Appearance appearance_of(uint predicates) {
  vec4 appearance = appearance_texel(int(predicates));
  return Appearance(appearance.rgb, appearance.a);
}
#else
uniform samplerBuffer weights;  // Two texels for each entry, see appearance_of().
uniform int entry_count;
uniform bool linear_hue;
uniform float greatest_impact;

// Like spec::hsl_tint().
vec3 tint_of(float hue_deg, float saturation) {
  vec3 shifted = mod(hue_deg / 60.0 + vec3(0.0, 4.0, 2.0), 6.0);
  return saturation * (clamp(abs(shifted - 3.0) - 1.0, 0.0, 1.0) - 0.5);
}

Appearance appearance_of(uint entries) {
  vec3 sum = vec3(0.0);   // Count, impact, impact times saturation.
  vec4 hues = vec4(0.0);  // Weighted by that: cosine, sine, degrees; weight.
  vec2 most = vec2(0.0);  // Greatest weight, and its hue.
  for (int j = 0; j < entry_count; ++j) {
    if ((entries >> uint(j) & 1u) == 0u) continue;
    vec3 impact = texelFetch(weights, 2 * j).rgb;  // Impact, impact times saturation, hue.
    sum += vec3(1.0, impact.xy);
    hues += texelFetch(weights, 2 * j + 1);
    if (impact.y > most.x) most = impact.yz;
  }
  if (!(sum.y > 0.0)) return Appearance(vec3(0.0), 0.0);
  const float kCancelled = 1.0e-6;  // Far above the rounding of 32 terms.
  float hue = degrees(atan(hues.y, hues.x));
  if (length(hues.xy) <= kCancelled * hues.w) hue = most.y;
  if (linear_hue) hue = hues.z / max(hues.w, 1.0e-30);
  vec3 tint = hues.w > 0.0 ? tint_of(hue, min(sum.z / sum.y, 1.0)) : vec3(0.0);
  float importance = sum.y / sum.x;
#ifndef LOG_IMPORTANCE
  importance = exp(importance - greatest_impact);
#endif
  return Appearance(tint, importance);
}
#endif
