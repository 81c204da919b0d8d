#version 410 core
// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Sums the cost of rays (lattice.glsl) over blocks of 16 × 16 pixels, so that little has to be read
// back. Result: samples, gradients, faded cells; rays + 512 × those of them that a cutaway meets.
// All are whole numbers that single precision represents.

uniform sampler2D spent;
layout(location = 0) out vec4 sums;

void main() {
  const int kSide = 16;
  ivec2 first = kSide * ivec2(gl_FragCoord.xy);
  ivec2 end = min(first + kSide, textureSize(spent, 0));
  vec4 sum = vec4(0.0);
  for (int y = first.y; y < end.y; ++y) {
    for (int x = first.x; x < end.x; ++x) {
      vec4 cost = texelFetch(spent, ivec2(x, y), 0);
      sum += vec4(cost.xyz, (cost.w > 0.0 ? 1.0 : 0.0) + (cost.w > 1.0 ? 512.0 : 0.0));
    }
  }
  sums = sum;
}
