// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/overlay.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>

namespace nav::app {

int text_size(int text_px, int image_height) {
  constexpr double kUsualHeight = 600;
  const double scale = std::max(1.0, image_height / kUsualHeight);
  return static_cast<int>(std::lround(text_px * scale));
}

void draw_letters(render::Canvas& canvas, const CanvasArea& area,
                  const render::SliceLabels& letters, int size, Rgba8 colour) {
  const int margin = std::max(6, size * 3 / 8);
  const int middle = area.y + area.height / 2 + size / 3;
  const auto at = [&](int x, int base, const std::string& text) {
    if (!text.empty()) canvas.outlined_text(x, base, size, text, colour);
  };
  const auto centred = [&](const std::string& text) {
    return area.x + (area.width - canvas.text_width(size, text)) / 2;
  };
  at(area.x + margin, middle, letters.left);
  at(area.x + area.width - margin - canvas.text_width(size, letters.right), middle, letters.right);
  at(centred(letters.top), area.y + margin + size, letters.top);
  at(centred(letters.bottom), area.y + area.height - margin, letters.bottom);
}

void draw_scale_bar(render::Canvas& canvas, const CanvasArea& area, int x, int base,
                    double mm_per_px, int size, Rgba8 colour) {
  const double most_mm = area.width / 5.0 * mm_per_px;
  if (!(most_mm > 1e-3) || !std::isfinite(most_mm)) return;
  const double decade = std::pow(10.0, std::floor(std::log10(most_mm)));
  double length_mm = decade;
  for (const double step : {2.0, 5.0}) {
    if (step * decade <= most_mm) length_mm = step * decade;
  }
  std::ostringstream text;
  text << length_mm << " mm";
  const int length = static_cast<int>(std::lround(length_mm / mm_per_px));
  const int gap = size / 2;
  if (x + length + gap + canvas.text_width(size, text.str()) > area.x + area.width) return;
  const double thick = std::max(2.0, size / 6.0);
  const double y = base - size / 3.0;
  const double tick = size / 3.0;
  for (const auto& [width, ink] : {std::pair(thick + 2, render::rgb8(0)), {thick, colour}}) {
    canvas.line({1.0 * x, y}, {1.0 * x + length, y}, width, ink);
    canvas.line({1.0 * x, y - tick}, {1.0 * x, y + tick}, width, ink);
    canvas.line({1.0 * x + length, y - tick}, {1.0 * x + length, y + tick}, width, ink);
  }
  canvas.outlined_text(x + length + gap, base, size, text.str(), colour);
}

std::string position_words(const Eigen::Vector3d& ct_mm) {
  constexpr std::array<std::array<char, 2>, 3> kLetters{{{'L', 'R'}, {'P', 'A'}, {'S', 'I'}}};
  std::string words;
  for (int axis = 0; axis < 3; ++axis) {
    const double mm = std::round(10 * ct_mm[axis]) / 10;
    char number[48];
    std::snprintf(number, sizeof number, "%s%c %.1f", axis == 0 ? "" : "  ",
                  kLetters[static_cast<std::size_t>(axis)][mm < 0 ? 1 : 0], std::abs(mm));
    words += number;
  }
  return "at " + words + " mm";
}

}  // namespace nav::app
