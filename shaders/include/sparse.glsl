// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Fewer rays than pixels. Either a pass draws every pixel_step-th column and row of the image, with
// the upper left pixel in the first fragment; the last pass, with step 1, draws the image itself,
// bottom row first. Or a list gives the pixels of the fragments: render/gl/gl_packed_rays.hpp.

#ifdef PACKED_RAYS
uniform isamplerBuffer ray_list;  // Column | row << 16 of pixels, for blocks of 4 x 4 fragments.
uniform int ray_columns;          // Columns of the fragments, a multiple of 4.
#else
uniform int pixel_step;  // Pixels between fragments.
#endif

ivec2 pixel;        // Pixel of the fragment, row 0 at the top.
vec2 pixel_centre;  // Row 0 at the bottom.

void set_pixel() {
  ivec2 fragment = ivec2(fragment_centre);
  int height = int(picture_size.y);
#ifdef PACKED_RAYS
  int block = (fragment.y >> 2) * (ray_columns >> 2) + (fragment.x >> 2);
  int place = texelFetch(ray_list, block * 16 + (fragment.y & 3) * 4 + (fragment.x & 3)).r;
  pixel = ivec2(place & 0xFFFF, place >> 16);
#else
  pixel = fragment * pixel_step;
  if (pixel_step == 1) pixel.y = height - 1 - pixel.y;
#endif
  pixel_centre = vec2(pixel.x, height - 1 - pixel.y) + 0.5;
}
