// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "nav/image.hpp"
#include "render/letters.hpp"

namespace nav::render {

/// Ink of each pixel of a line of text, 0 to 255.
struct TextMask {
  Image2d<std::uint8_t> coverage;  ///< Top row first; tight to the ink; at least 1 x 1.
  int ascent;                      ///< Rows above the base line.
};

/// Draws a line of UTF-8 text with VTK's built-in sans-serif font, which has Latin letters and few
/// others; it is the same on every system. Draws '?' for letters that the font does not have.
TextMask rasterise_text(const std::string& words, int size_px);

/// True if the font has a letter. VTK draws nothing for other letters.
bool is_drawn(const Letter& letter);
/// A text with '?' in place of each letter that the font does not have.
std::string drawable_text(const std::string& words);

}  // namespace nav::render
