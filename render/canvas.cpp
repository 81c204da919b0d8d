// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "render/vtk/vtk_text.hpp"

namespace nav::render {

Canvas::Canvas(int width, int height, Rgba8 background) : width_(width), height_(height) {
  constexpr int kMaxSide = 16384;
  NAV_CHECK(width >= 1 && height >= 1 && width <= kMaxSide && height <= kMaxSide, width, height);
  pixels_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), background);
}

void Canvas::set(int x, int y, Rgba8 colour) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
          static_cast<std::size_t>(x)] = colour;
}

void Canvas::blend(int x, int y, Rgba8 colour, double opacity) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_ || !(opacity > 0)) return;
  Rgba8& under = pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                         static_cast<std::size_t>(x)];
  const double a = std::min(opacity, 1.0);
  const auto mix = [a](std::uint8_t below, std::uint8_t above) {
    return static_cast<std::uint8_t>(std::lround(below + a * (above - below)));
  };
  under = {mix(under.r, colour.r), mix(under.g, colour.g), mix(under.b, colour.b), 255};
}

void Canvas::copy(const Image2d<Rgba8>& image, int x, int y) {
  for (int row = 0; row < image.height(); ++row) {
    for (int column = 0; column < image.width(); ++column) {
      const Rgba8& colour = image.at(column, row);
      if (colour.a != 0) set(x + column, y + row, colour);
    }
  }
}

void Canvas::fill(int x, int y, int width, int height, Rgba8 colour) {
  for (int row = y; row < y + height; ++row) {
    for (int column = x; column < x + width; ++column) set(column, row, colour);
  }
}

void Canvas::line(Eigen::Vector2d from, Eigen::Vector2d to, double width, Rgba8 colour,
                  double dash) {
  if (!from.allFinite() || !to.allFinite()) return;
  const double half = 0.5 * width;
  const double length = (to - from).norm();
  const Eigen::Vector2d along =
      length > 0 ? Eigen::Vector2d((to - from) / length) : Eigen::Vector2d(1, 0);
  const Eigen::Array2d low = from.cwiseMin(to).array() - half - 1;
  const Eigen::Array2d high = from.cwiseMax(to).array() + half + 1;
  const int x0 = static_cast<int>(std::clamp(low.x(), 0.0, 1.0 * width_));
  const int x1 = static_cast<int>(std::clamp(high.x(), -1.0, 1.0 * width_ - 1));
  const int y0 = static_cast<int>(std::clamp(low.y(), 0.0, 1.0 * height_));
  const int y1 = static_cast<int>(std::clamp(high.y(), -1.0, 1.0 * height_ - 1));
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const Eigen::Vector2d p = Eigen::Vector2d(x, y) - from;
      const double s = std::clamp(p.dot(along), 0.0, length);
      if (dash > 0 && std::fmod(s, 2 * dash) >= dash) continue;
      blend(x, y, colour, half + 0.5 - (p - s * along).norm());
    }
  }
}

void Canvas::circle(Eigen::Vector2d centre, double radius, double width, Rgba8 colour) {
  if (!centre.allFinite() || !std::isfinite(radius)) return;
  const double reach = radius + width;
  const int x0 = static_cast<int>(std::clamp(centre.x() - reach, 0.0, 1.0 * width_));
  const int x1 = static_cast<int>(std::clamp(centre.x() + reach, -1.0, 1.0 * width_ - 1));
  const int y0 = static_cast<int>(std::clamp(centre.y() - reach, 0.0, 1.0 * height_));
  const int y1 = static_cast<int>(std::clamp(centre.y() + reach, -1.0, 1.0 * height_ - 1));
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const double distance = (Eigen::Vector2d(x, y) - centre).norm();
      blend(x, y, colour, 0.5 * width + 0.5 - std::abs(distance - radius));
    }
  }
}

int Canvas::text(int x, int y, int size, const std::string& words, Rgba8 colour) {
  const TextMask mask = rasterise_text(words, size);
  // Part of a number would read as another number, so text that does not fit is left out.
  if (x < 0 || x + mask.coverage.width() > width_) return x + mask.coverage.width();
  for (int row = 0; row < mask.coverage.height(); ++row) {
    for (int column = 0; column < mask.coverage.width(); ++column) {
      blend(x + column, y - mask.ascent + row, colour, mask.coverage.at(column, row) / 255.0);
    }
  }
  return x + mask.coverage.width();
}

int Canvas::outlined_text(int x, int y, int size, const std::string& words, Rgba8 colour) {
  constexpr Rgba8 kOutline = {0, 0, 0, 255};
  const TextMask mask = rasterise_text(words, size);
  const int end = x + mask.coverage.width();
  if (x < 0 || end > width_) return end;
  const int reach = std::max(1, size / 10);
  // The greatest ink within reach, so that no pixel is darkened twice.
  for (int row = -reach; row < mask.coverage.height() + reach; ++row) {
    for (int column = -reach; column < mask.coverage.width() + reach; ++column) {
      std::uint8_t most = 0;
      for (int r = std::max(row - reach, 0); r <= std::min(row + reach, mask.coverage.height() - 1);
           ++r) {
        for (int c = std::max(column - reach, 0);
             c <= std::min(column + reach, mask.coverage.width() - 1); ++c) {
          most = std::max(most, mask.coverage.at(c, r));
        }
      }
      blend(x + column, y - mask.ascent + row, kOutline, most / 255.0);
    }
  }
  return text(x, y, size, words, colour);
}

int Canvas::text_width(int size, const std::string& words) const {
  return rasterise_text(words, size).coverage.width();
}

std::vector<std::string> wrapped(int size, const std::string& words, int width) {
  std::vector<std::string> lines;
  std::istringstream stream(words);
  for (std::string word; stream >> word;) {
    const std::string longer = lines.empty() ? word : lines.back() + " " + word;
    if (lines.empty() || rasterise_text(longer, size).coverage.width() > width) {
      lines.push_back(word);
    } else {
      lines.back() = longer;
    }
  }
  return lines;
}

std::vector<Letter> letters_not_drawn(const std::string& words) {
  std::vector<Letter> missing;
  for (const Letter& letter : letters_of(words)) {
    const bool known = std::ranges::find(missing, letter.bytes, &Letter::bytes) != missing.end();
    if (!known && !is_drawn(letter)) missing.push_back(letter);
  }
  return missing;
}

}  // namespace nav::render
