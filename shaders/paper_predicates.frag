#version 410 core
// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Schulte zu Berge et al. 2014 as they describe it, to compare with in the benchmark: every sample
// from entry to exit, a texture for each feature, Eqs. 3 to 8 with the linear mean of hues and Eqs.
// 10 to 12 for each sample. Misprints are corrected as in render/spec/predicate_spec.hpp, and
// samples lie on the same lattice, so that the image is the same. The predicates, the features and
// sum_bars() come before this text: bench/paper_shader.cpp.
// Result: premultiplied colour and alpha.

#include "include/camera.glsl"
#include "include/taken_over.glsl"
#include "include/ct.glsl"
#include "include/compositing.glsl"
#include "include/lattice.glsl"

uniform vec2 intensity_of_volume;  // Scale, offset.
uniform float per_opacity_length;  // 1/mm.
uniform float most_opacity;
uniform vec3 spacing_mm;
uniform usampler3D paper_labels;
#ifdef COMPUTE
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = 0) writeonly uniform image2D target;
#else
layout(location = 0) out vec4 colour;
#endif

vec3 rgb_of_hsl(float hue_deg, float saturation, float luminance) {
  vec3 pure = clamp(abs(mod(hue_deg / 60.0 + vec3(0.0, 4.0, 2.0), 6.0) - 3.0) - 1.0, 0.0, 1.0);
  return luminance + (1.0 - abs(2.0 * luminance - 1.0)) * saturation * (pure - 0.5);
}

vec4 cast_ray(vec2 fragment_centre) {
  Ray ray = ray_of_pixel(fragment_centre);
  set_lattice(ray);
  vec2 box =
      clip_to_box(index_from_local * ray.origin, index_from_local * ray.direction, -t_base_mm);
  float begin = cells_of(box.x);
  float end = cells_of(box.y);
  int last = end > begin ? int(ceil(end)) : int(floor(begin));
  vec4 light = vec4(0.0);  // Premultiplied.
  float importance = 0.0;
  for (int n = int(floor(begin)); n < last; ++n) {
    vec3 index = clamp(index_at(float(n) + 0.5), vec3(0.0), vec3(ct_size - 1));
    float volume = ct_hu(index);
    vec4 texels[FEATURES];
    fetch_features(texels, index);
    uint labels = 0u;
#ifdef LABELS
    labels = texelFetch(paper_labels, ivec3(index + 0.5), 0).r;
#endif
    float x = clamp(volume * intensity_of_volume.x + intensity_of_volume.y, 0.0, 1.0);
    float part = min(float(n + 1), end) - max(float(n), begin);
    float alpha = 1.0 - pow(1.0 - min(x, most_opacity), part * step_mm * per_opacity_length);
    uint leaves = predicate_leaves(texels, volume, 0u, labels, spacing_mm * index);
    // Count, impact, impact times saturation, that times hue.
    vec4 sum = sum_bars(predicate_entries(leaves));
    if (!(sum.y > 0.0 && alpha > 0.0)) continue;
    float kappa = sum.y / sum.x;
    float hue = sum.z > 0.0 ? sum.w / sum.z : 0.0;
    vec3 own = alpha * rgb_of_hsl(hue, sum.z / sum.y, x);
    float vis = 1.0 - exp(importance - kappa);
    bool over = kappa <= importance || 1.0 - light.a >= vis;
    float m = over ? 1.0 : (1.0 - vis) / light.a;
    vec3 mixed = m * light.rgb + (1.0 - m * light.a) * own;
    float modulated = m * light.a * (1.0 - alpha) + alpha;
    float next = light.a * (1.0 - alpha) + alpha;
    light = vec4(modulated > 0.0 ? next * mixed / modulated : vec3(0.0), next);
    importance = max(importance, log(alpha + (1.0 - alpha) * exp(importance - kappa)) + kappa);
  }
  return light;
}

void main() {
#ifdef COMPUTE
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (all(lessThan(vec2(pixel), image_size)))
    imageStore(target, pixel, cast_ray(vec2(pixel) + 0.5));
#else
  colour = cast_ray(gl_FragCoord.xy);
#endif
}
