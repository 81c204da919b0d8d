// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "nav/image.hpp"

namespace nav::render {

/// How much ink each pixel of a line of text has, 0 to 255.
struct TextMask {
  Image2d<std::uint8_t> coverage;  ///< Top row first; tight to the ink; at least 1 x 1.
  int ascent;                      ///< Rows above the base line.
};

/// Draws a line of UTF-8 text with VTK's built-in sans-serif font; the same everywhere.
TextMask rasterise_text(const std::string& words, int size_px);

}  // namespace nav::render
