#version 410 core
// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Puts the ultrasound image between the layers in front of it and behind it. A new image at the
// same position needs only this pass.

#include "include/compositing.glsl"

uniform sampler2D front;       // Premultiplied.
uniform sampler2D behind;
uniform sampler2D live_at;     // Column and row of the image; far below 0 if it is not visible.
uniform sampler2D us_image;  // Grey in [0, 1], 16 bit; first texel row: shallowest.
uniform float plane_opacity;   // (0, 1].
uniform float opaque_at;       // See raycast.frag.
uniform bool by_weight;        // One layer; its other part is the weight of the image in it.
layout(location = 0) out vec4 colour;

// Bilinear between pixel centres, clamped to the outermost. Done by hand, because filters of
// devices have as few as 256 levels between two pixels.
float image_at(vec2 pixel) {
  ivec2 size = textureSize(us_image, 0);
  vec2 p = clamp(pixel, vec2(0.0), vec2(size - 1));
  ivec2 a = min(ivec2(p), max(size - 2, 0));
  ivec2 b = min(a + 1, size - 1);
  vec2 f = p - vec2(a);
  float top = mix(texelFetch(us_image, a, 0).r, texelFetch(us_image, ivec2(b.x, a.y), 0).r, f.x);
  float bottom =
      mix(texelFetch(us_image, ivec2(a.x, b.y), 0).r, texelFetch(us_image, b, 0).r, f.x);
  return mix(top, bottom, f.y);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 layers = texelFetch(front, pixel, 0);
  vec2 at = texelFetch(live_at, pixel, 0).xy;
  if (by_weight) {
    if (at.x > -1.0e6) layers.rgb += texelFetch(behind, pixel, 0).r * image_at(at);
    colour = layers;
    return;
  }
  if (at.x > -1.0e6) {
    put_behind(layers, vec3(image_at(at)), plane_opacity);
    layers += (1.0 - layers.a) * texelFetch(behind, pixel, 0);
  }
  colour = closed(layers, opaque_at);
}
