#version 410 core
// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Arithmetic that no compiler can leave out, as a fragment shader or, with COMPUTE, as a compute
// shader. Result: numbers without meaning, [0, 1].

uniform int turns;
#ifdef COMPUTE
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = 0) writeonly uniform image2D target;
#else
layout(location = 0) out vec4 colour;
#endif

vec4 logistic(vec2 place) {
  vec4 x = fract(vec4(place, place.yx + 0.5) * 0.001) * 0.5 + 0.25;
  for (int i = 0; i < turns; ++i) x = 3.7 * x * (1.0 - x);
  return x;
}

void main() {
#ifdef COMPUTE
  imageStore(target, ivec2(gl_GlobalInvocationID.xy), logistic(vec2(gl_GlobalInvocationID.xy) + 0.5));
#else
  colour = logistic(gl_FragCoord.xy);
#endif
}
