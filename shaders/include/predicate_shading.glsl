// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Shading of samples by predicates: PredicateShading of render/predicates/predicate_scene.hpp. The
// gradient stays on the index axes, because only its length and its angle to the ray matter.

uniform sampler3D predicate_gradients;  // Differences of each voxel's neighbours, as values of ct.
uniform vec3 predicate_half_per_spacing;  // 1 / (2 * spacing), per mm.
uniform mat3 predicate_axes_from_local;   // Rotation (or mirror) to the index axes.
uniform float predicate_full_gradient;    // Stored values per mm.
uniform vec4 predicate_light;             // Ambient, diffuse, specular, shininess.

vec3 predicate_ray_axes;  // The ray's direction along the index axes.
vec3 predicate_per_difference;  // Copies: taken_over.glsl.
float predicate_full_taken;
vec4 predicate_light_taken;

// Call it after set_lattice().
void take_over_predicate_shading() {
  predicate_ray_axes = predicate_axes_from_local * ray_direction;
  predicate_per_difference = taken_over(predicate_half_per_spacing);
  predicate_full_taken = taken_over(predicate_full_gradient);
  predicate_light_taken = vec4(taken_over(predicate_light.xyz), taken_over(predicate_light.w));
}

vec3 shaded_sample(vec3 rgb, vec3 index) {
  vec3 gradient = trilinear(predicate_gradients, index).rgb * predicate_per_difference;
  float norm = length(gradient);
  if (!(norm > 0.0)) return rgb;
  vec3 full = phong(rgb, dot(gradient, predicate_ray_axes) / norm, predicate_light_taken);
  return mix(rgb, full, min(1.0, norm / predicate_full_taken));
}
