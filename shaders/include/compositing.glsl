// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Front to back, premultiplied. Colour and alpha in [0, 1], lengths in mm.

// 1 - exp(-x), x >= 0, without the cancellation at small x.
float opacity_of(float x) {
  float series = x * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0))));
  return x < 0.1 ? series : 1.0 - exp(-x);
}

// What a ray that ended early has gathered stands for the rest of it.
vec4 closed(vec4 picture, float opaque_at) {
  return picture.a >= opaque_at ? picture / picture.a : picture;
}

void put_behind(inout vec4 picture, vec3 rgb, float alpha) {
  float part = (1.0 - picture.a) * alpha;
  picture += vec4(part * rgb, part);
}
