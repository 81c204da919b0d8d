#version 410 core
// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Measures the interpolation of the device: column x of an image of sample_count columns reads a
// texture of two texels, 0 and 1, at the fraction x / sample_count. Result: the value read, [0, 1].

uniform sampler3D two_texels;
uniform float sample_count;
layout(location = 0) out vec4 colour;

void main() {
  float fraction = floor(gl_FragCoord.x) / sample_count;
  colour = vec4(textureLod(two_texels, vec3((0.5 + fraction) / 2.0, 0.5, 0.5), 0.0).r);
}
