// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "render/window/window.hpp"

namespace nav::render {

/// A line of overlay text as a window draws it.
struct PlacedWords {
  std::string words;
  Rgba8 colour;
  double x_px;  ///< Aligned point, from the left of the window.
  double y_px;  ///< Middle of the text, from the top of the window.
  WindowWords::Align align;
  int size_px;
};

/// Height that a line of a stack takes up, pixels.
int line_height_px(int size_px);

/// Places overlay text in a window of a size in pixels: nothing overlaps, and lines lie inside as a
/// whole. Stacked text is wrapped. If there is not enough room, its size falls, down to 8 pixels.
/// Lines that still do not fit are left out, first from the end of the downward stack.
std::vector<PlacedWords> placed_words(const std::vector<WindowWords>& words, int width, int height);

}  // namespace nav::render
