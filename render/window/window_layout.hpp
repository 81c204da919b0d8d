// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "render/window/window.hpp"

namespace nav::render {

/// A line of words as a window draws it.
struct PlacedWords {
  std::string words;
  Rgba8 colour;
  double x_px;  ///< Of the aligned point, from the window's left …
  double y_px;  ///< … and of the words' middle, from its top.
  WindowWords::Align align;
  int size_px;
};

/// Height that a line of a stack takes up, pixels.
int line_height_px(int size_px);

/// Where words stand in a window of a size in pixels: nothing over anything else, whole lines
/// inside. Stacked words are wrapped and, where they have no room, smaller, down to 8 pixels; what
/// has none even so is left out, of the stack downwards first, from its end.
std::vector<PlacedWords> placed_words(const std::vector<WindowWords>& words, int width, int height);

}  // namespace nav::render
