#version 410 core
// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Puts the finished image over what VTK has drawn. Premultiplied colour in [0, 1], blended with
// (one, one minus source alpha). An image with fewer pixels is interpolated bilinearly between
// their centres.

uniform sampler2D image;
uniform float scale;  // Pixels of the image per pixel of the target; 1: one to one.
uniform vec2 offset;  // In pixels of the image.
layout(location = 0) out vec4 colour;

void main() {
  vec2 at = scale * gl_FragCoord.xy + offset;
  if (scale == 1.0) {
    colour = texelFetch(image, ivec2(floor(at)), 0);
    return;
  }
  ivec2 last = textureSize(image, 0) - 1;
  vec2 place = clamp(at - 0.5, vec2(0.0), vec2(last));
  ivec2 a = ivec2(place);
  ivec2 b = min(a + 1, last);
  vec2 f = place - vec2(a);
  vec4 low = mix(texelFetch(image, a, 0), texelFetch(image, ivec2(b.x, a.y), 0), f.x);
  vec4 high = mix(texelFetch(image, ivec2(a.x, b.y), 0), texelFetch(image, b, 0), f.x);
  colour = mix(low, high, f.y);
}
