// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compositing front to back, premultiplied. Colour and alpha in [0, 1], lengths in mm.

// 1 - exp(-x), x >= 0, without the cancellation at small x. With exp(-x) = 2^-whole 2^-part it is
// 1 - 2^-whole, which is exact, plus 2^-whole (1 - 2^-part), whose polynomial has a relative error
// of 1e-8. precise: programs that draw the same image give the same bits.
float opacity_of(float x) {
  precise float y = min(1.44269504 * x, 126.0);
  float whole = floor(y);
  precise float part = y - whole;
  precise float less = fma(part, -0.00011491995, 0.0012916369);
  less = fma(part, less, -0.009597035);
  less = fma(part, less, 0.05549923);
  less = fma(part, less, -0.24022609);
  less = part * fma(part, less, 0.69314717);
  float power = uintBitsToFloat(uint(127 - int(whole)) << 23u);
  precise float opacity = fma(power, less, 1.0 - power);
  return opacity;
}

// Completes a ray that ended early: what it has gathered stands for its rest too.
vec4 closed(vec4 layer, float opaque_at) {
  return layer.a >= opaque_at ? layer / layer.a : layer;
}

void put_behind(inout vec4 layer, vec3 rgb, float alpha) {
  float part = (1.0 - layer.a) * alpha;
  layer += vec4(part * rgb, part);
}
