// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "nav/volume.hpp"
#include "render/letters.hpp"

namespace nav::render {

/// Straight-alpha 8-bit colour from 0xRRGGBB.
constexpr Rgba8 rgb8(unsigned hex) {
  return {static_cast<std::uint8_t>(hex >> 16 & 0xff), static_cast<std::uint8_t>(hex >> 8 & 0xff),
          static_cast<std::uint8_t>(hex & 0xff), 255};
}

/// An image under construction: the views, lines and text of one display refresh. Coordinates are
/// pixels, x right, y down, (0, 0) the top left corner. What falls outside the image is cut off.
/// Not thread-safe.
class Canvas {
 public:
  /// Precondition: sizes in [1, 16384]; otherwise a Bug.
  Canvas(int width, int height, Rgba8 background);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  void set(int x, int y, Rgba8 colour);
  void blend(int x, int y, Rgba8 colour, double opacity);
  /// Copies an image with its top left corner at (x, y). Transparent pixels (alpha 0) leave what is
  /// there.
  void copy(const Image2d<Rgba8>& image, int x, int y);
  void fill(int x, int y, int width, int height, Rgba8 colour);
  /// Draws an anti-aliased segment; width in pixels. dash: length of the dashes and of the gaps in
  /// pixels; 0: a solid line.
  void line(Eigen::Vector2d from, Eigen::Vector2d to, double width, Rgba8 colour, double dash = 0);
  void circle(Eigen::Vector2d centre, double radius, double width, Rgba8 colour);
  /// Draws one line of UTF-8 text with a capital height of about 0.7 · size pixels. (x, y) is the
  /// left end of the base line. Returns the x at which the text ends. Text that does not fit into
  /// the rest of the image is left out as a whole, so that no number ever lacks digits.
  int text(int x, int y, int size, const std::string& words, Rgba8 colour);
  /// Like text(), with a dark outline, so that it is legible on any background.
  int outlined_text(int x, int y, int size, const std::string& words, Rgba8 colour);
  [[nodiscard]] int text_width(int size, const std::string& words) const;

  [[nodiscard]] Image2d<Rgba8> image() const { return {width_, height_, pixels_}; }

 private:
  int width_;
  int height_;
  std::vector<Rgba8> pixels_;
};

/// Splits text at spaces into lines of at most width pixels. A word that is wider has a line of its
/// own.
std::vector<std::string> wrapped(int size, const std::string& words, int width);

/// The letters of a UTF-8 text that Canvas::text() draws as '?', each once, in order. Its font has
/// the Latin letters and few others.
std::vector<Letter> letters_not_drawn(const std::string& words);

}  // namespace nav::render
