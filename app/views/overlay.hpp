// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "nav/transform.hpp"
#include "render/canvas.hpp"
#include "render/slices/slice.hpp"

namespace nav::app {

/// Colour of overlay text that is not a warning.
inline constexpr Rgba8 kOverlayText = render::rgb8(0xd8dee4);

/// Rectangle of a canvas, pixels.
struct CanvasArea {
  int x, y, width, height;
};

/// Size of text for an image of a height: text_px on images of up to 600 pixels, larger in
/// proportion on larger ones.
int text_size(int text_px, int image_height);

/// Draws the letters of the patient's directions at the middle of the four edges of a flat image,
/// outlined. Empty letters are left out.
void draw_letters(render::Canvas& canvas, const CanvasArea& area,
                  const render::SliceLabels& letters, int size, Rgba8 colour = kOverlayText);

/// Draws a bar of a round length (1, 2 or 5 times a power of ten, at most a fifth of the width)
/// with its length in mm, its left end at (x, base). Left out where it does not fit.
void draw_scale_bar(render::Canvas& canvas, const CanvasArea& area, int x, int base,
                    double mm_per_px, int size, Rgba8 colour = kOverlayText);

/// Position in the patient in words, rounded to 0.1 mm: "at R 12.0  A 34.5  S 6.1 mm". The letter
/// tells the sign: R or L of the origin of the CT, A or P, S or I.
std::string position_words(const Eigen::Vector3d& ct_mm);

}  // namespace nav::app
