// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Fewer rays than pixels. A pass draws every pixel_step-th column and row of the image, with the
// upper left pixel in the first fragment. The last pass, with step 1, draws the image itself,
// bottom row first.

uniform int pixel_step;  // Pixels between fragments.

ivec2 pixel;        // Pixel of the fragment, row 0 at the top.
vec2 pixel_centre;  // Row 0 at the bottom.

void set_pixel() {
  ivec2 fragment = ivec2(fragment_centre);
  int height = int(image_size.y);
  pixel = fragment * pixel_step;
  if (pixel_step == 1) pixel.y = height - 1 - pixel.y;
  pixel_centre = vec2(pixel.x, height - 1 - pixel.y) + 0.5;
}
