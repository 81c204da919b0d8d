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

/// A picture under construction: views, lines and words of one display refresh. Coordinates are
/// pixels, x right, y down, (0, 0) the top left corner; what falls outside is cut. Not thread-safe.
class Canvas {
 public:
  /// Precondition: sizes in [1, 16384], otherwise a Bug.
  Canvas(int width, int height, Rgba8 background);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  void set(int x, int y, Rgba8 colour);
  void blend(int x, int y, Rgba8 colour, double opacity);
  /// Transparent pixels (alpha 0) leave what is there.
  void copy(const Image2d<Rgba8>& picture, int x, int y);
  void fill(int x, int y, int width, int height, Rgba8 colour);
  /// Anti-aliased segment of a width in pixels; dash 0: solid, else the length of dashes and gaps.
  void line(Eigen::Vector2d from, Eigen::Vector2d to, double width, Rgba8 colour, double dash = 0);
  void circle(Eigen::Vector2d centre, double radius, double width, Rgba8 colour);
  /// One line of text in UTF-8 whose capital height is about 0.7 · size pixels; (x, y) is the left
  /// end of the base line. Returns the x where it ends. Text that is wider than what is left of the
  /// picture is left out whole: never a number with missing digits.
  int text(int x, int y, int size, const std::string& words, Rgba8 colour);
  [[nodiscard]] int text_width(int size, const std::string& words) const;

  [[nodiscard]] Image2d<Rgba8> picture() const { return {width_, height_, pixels_}; }

 private:
  int width_;
  int height_;
  std::vector<Rgba8> pixels_;
};

/// Words in lines of at most a width in pixels, cut at spaces; a word that is wider stands alone.
std::vector<std::string> wrapped(int size, const std::string& words, int width);

/// The letters of a text in UTF-8 that Canvas::text() draws as '?', each once, in order: its font
/// has Latin ones and few others.
std::vector<Letter> letters_not_drawn(const std::string& words);

}  // namespace nav::render
