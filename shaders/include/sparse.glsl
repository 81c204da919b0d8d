// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Fewer rays than pixels: a pass draws every pixel_step-th column and row of the picture, the upper
// left pixel in the first fragment. The last pass, of 1, draws the picture itself, bottom row first.

uniform int pixel_step;  // Pixels between fragments.

ivec2 pixel;        // Of the fragment, row 0 at the top.
vec2 pixel_centre;  // Row 0 at the bottom.

void set_pixel() {
  pixel = ivec2(gl_FragCoord.xy) * pixel_step;
  int height = int(picture_size.y);
  if (pixel_step == 1) pixel.y = height - 1 - pixel.y;
  pixel_centre = vec2(pixel.x, height - 1 - pixel.y) + 0.5;
}
