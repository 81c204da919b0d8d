// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/window/window_layout.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "render/canvas.hpp"

namespace nav::render {
namespace {

using Stack = WindowWords::Stack;
constexpr int kMarginPx = 4;

class Layout {
 public:
  Layout(int width, int height) : width_(width), height_(height) {}

  void add_single(const WindowWords& w) {
    const double half = 0.5 * line_height_px(w.size_px);
    const double y = std::max(half, std::min(w.y * height_, height_ - half));
    taken_.push_back({y - half, y + half});
    lines_.push_back({w.words, w.colour, w.x * width_, y, w.align, w.size_px});
  }
  /// Adds the lines of one stack, in its own order. Returns false if there is not enough room for
  /// all.
  bool add_stack(const std::vector<WindowWords>& words, Stack stack, int most_px) {
    const double way = stack == Stack::kDown ? 1 : -1;
    double low = height_;
    double high = 0;
    std::optional<double> y;
    bool whole = true;
    for (const WindowWords& w : words) {
      if (w.stack != stack || w.words.empty()) continue;
      const int size = std::min(w.size_px, most_px);
      const double half = 0.5 * line_height_px(size);
      auto lines = wrapped(size, w.words, width_ - 2 * margin(w));
      if (stack == Stack::kUp) std::ranges::reverse(lines);
      for (std::string& line : lines) {
        y = beside(y.value_or(w.y * height_), half, way);
        if (*y < half || *y > height_ - half || !whole) {
          whole = false;
          continue;
        }
        low = std::min(low, *y - half);
        high = std::max(high, *y + half);
        lines_.push_back({std::move(line), w.colour, w.x * width_, *y, w.align, size});
        *y += 2 * way * half;
      }
    }
    // The next stack stops where this one ends.
    if (high > low) taken_.push_back(way > 0 ? Span{0, high} : Span{low, 1.0 * height_});
    return whole;
  }
  [[nodiscard]] std::vector<PlacedWords> lines() const { return lines_; }

 private:
  struct Span {
    double low, high;
  };
  [[nodiscard]] int margin(const WindowWords& w) const {
    return std::max(kMarginPx, static_cast<int>(std::ceil(std::min(w.x, 1 - w.x) * width_)));
  }
  /// The nearest free position in the given direction.
  [[nodiscard]] double beside(double y, double half, double way) const {
    for (std::size_t i = 0; i < taken_.size();) {
      const Span& span = taken_[i++];
      if (y + half <= span.low || y - half >= span.high) continue;
      y = way > 0 ? span.high + half : span.low - half;
      i = 0;
    }
    return y;
  }

  int width_;
  int height_;
  std::vector<PlacedWords> lines_;
  std::vector<Span> taken_;
};

}  // namespace

int line_height_px(int size_px) { return static_cast<int>(std::ceil(1.4 * size_px)); }

std::vector<PlacedWords> placed_words(const std::vector<WindowWords>& words, int width,
                                      int height) {
  std::vector<PlacedWords> smallest;
  for (const int most_px : {512, 12, 10, 8}) {
    Layout layout(width, height);
    for (const WindowWords& w : words) {
      if (w.stack == Stack::kNone && !w.words.empty()) layout.add_single(w);
    }
    // States have priority over notes.
    const bool up = layout.add_stack(words, Stack::kUp, most_px);
    const bool down = layout.add_stack(words, Stack::kDown, most_px);
    smallest = layout.lines();
    if (up && down) break;
  }
  return smallest;
}

}  // namespace nav::render
