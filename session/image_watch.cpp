// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/image_watch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace nav::session {
namespace {

constexpr int kScreenBlock = 8;     ///< Pixels.
constexpr int kLearnedImages = 25;  ///< About a second.
constexpr int kImagesInARow = 3;
constexpr int kEcho = 24;          ///< Grey level; the black of a grabbed screen lies below.
constexpr int kEchoPixels = 4;     ///< Pixels of a block with echoes: less are noise.
constexpr int kDisplayStep = 48;   ///< Grey levels by which a digit differs from its background.
constexpr double kGrown = 0.02;    ///< Share of the blocks that were black.
constexpr double kShrunk = 0.15;   ///< Share of the blocks at the probe.
constexpr double kAtProbe = 0.08;  ///< Share of the height within which the probe's arc lies.
constexpr double kDisplayShare = 0.01;

}  // namespace

std::optional<ScreenArea> screen_area(const std::vector<double>& numbers) {
  constexpr double kMost = 65535;
  if (numbers.size() != 4) return std::nullopt;
  for (const double number : numbers) {
    if (!(number >= 0 && number <= kMost && number == std::floor(number))) return std::nullopt;
  }
  const ScreenArea area{static_cast<int>(numbers[0]), static_cast<int>(numbers[1]),
                        static_cast<int>(numbers[2]), static_cast<int>(numbers[3])};
  if (area.width < 1 || area.height < 1) return std::nullopt;
  return area;
}

const std::string& ImageWatch::look(const Image2d<std::uint8_t>& image) {
  if (learned_ < kLearnedImages && (learned_ == 0 || difference(image).empty())) {
    learn(image);
    return change_;
  }
  std::string found = difference(image);
  if (found == change_) {
    in_a_row_ = 0;
    return change_;
  }
  in_a_row_ = found == seen_ ? in_a_row_ + 1 : 1;
  seen_ = std::move(found);
  if (in_a_row_ >= kImagesInARow) {
    change_ = seen_;
    in_a_row_ = 0;
  }
  return change_;
}

ImageWatch::Blocks ImageWatch::lit_blocks(const Image2d<std::uint8_t>& image) const {
  std::vector<int> echoes(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  const auto pixels = image.pixels();
  const auto& display = options_.depth_display;
  std::size_t at = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x, ++at) {
      if (pixels[at] < kEcho) continue;
      const bool is_display = display && x >= display->left && x < display->left + display->width &&
                              y >= display->top && y < display->top + display->height;
      if (is_display) continue;
      ++echoes[static_cast<std::size_t>(y / kScreenBlock) * static_cast<std::size_t>(columns_) +
               static_cast<std::size_t>(x / kScreenBlock)];
    }
  }
  Blocks lit(echoes.size());
  for (std::size_t i = 0; i < lit.size(); ++i) lit[i] = echoes[i] >= kEchoPixels;
  return lit;
}

std::vector<std::uint8_t> ImageWatch::display_of(const Image2d<std::uint8_t>& image) const {
  std::vector<std::uint8_t> pixels;
  if (!options_.depth_display) return pixels;
  const ScreenArea& area = *options_.depth_display;
  const int right = std::min(area.left + area.width, image.width());
  const int bottom = std::min(area.top + area.height, image.height());
  for (int y = area.top; y < bottom; ++y) {
    for (int x = area.left; x < right; ++x) pixels.push_back(image.at(x, y));
  }
  return pixels;
}

void ImageWatch::learn(const Image2d<std::uint8_t>& image) {
  if (learned_ == 0) {
    width_ = image.width();
    height_ = image.height();
    columns_ = (width_ + kScreenBlock - 1) / kScreenBlock;
    rows_ = (height_ + kScreenBlock - 1) / kScreenBlock;
    times_lit_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0);
    display_ = display_of(image);
  }
  const Blocks lit = lit_blocks(image);
  for (std::size_t i = 0; i < lit.size(); ++i) times_lit_[i] += lit[i] ? 1 : 0;
  if (++learned_ == kLearnedImages) end_learning();
}

/// Blocks that were never lit, nor any beside them; and those at the probe: the first blocks of the
/// columns that were always lit, near the topmost of them. Farther down lie the sides of a sector,
/// which are dark while the probe is in air.
void ImageWatch::end_learning() {
  never_lit_.assign(times_lit_.size(), true);
  first_lit_.assign(times_lit_.size(), false);
  const auto index = [&](int column, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  };
  std::vector<int> begins(static_cast<std::size_t>(columns_), rows_);
  for (int column = 0; column < columns_; ++column) {
    for (int row = 0; row < rows_; ++row) {
      const int times = times_lit_[index(column, row)];
      int& begin = begins[static_cast<std::size_t>(column)];
      if (times == learned_) begin = std::min(begin, row);
      if (times == 0) continue;
      for (int y = std::max(0, row - 1); y <= std::min(rows_ - 1, row + 1); ++y) {
        for (int x = std::max(0, column - 1); x <= std::min(columns_ - 1, column + 1); ++x) {
          never_lit_[index(x, y)] = false;
        }
      }
    }
  }
  const int top = *std::ranges::min_element(begins);
  const int deepest = top + std::max(1, static_cast<int>(kAtProbe * rows_));
  for (int column = 0; column < columns_; ++column) {
    const int begin = begins[static_cast<std::size_t>(column)];
    if (begin < rows_ && begin <= deepest) first_lit_[index(column, begin)] = true;
  }
}

/// Difference from the learned screen, as a clause; empty: none.
std::string ImageWatch::difference(const Image2d<std::uint8_t>& image) const {
  if (image.width() != width_ || image.height() != height_) {
    return "the screen of the scanner has " + std::to_string(image.width()) + " x " +
           std::to_string(image.height()) + " pixels, at first " + std::to_string(width_) + " x " +
           std::to_string(height_);
  }
  const auto display = display_of(image);
  std::size_t changed = 0;
  for (std::size_t i = 0; i < display.size(); ++i) {
    if (std::abs(int{display[i]} - int{display_[i]}) >= kDisplayStep) ++changed;
  }
  if (static_cast<double>(changed) > kDisplayShare * static_cast<double>(display.size())) {
    return "the depth display of the scanner shows another depth than at first";
  }
  if (learned_ < kLearnedImages) return "";
  const Blocks lit = lit_blocks(image);
  std::size_t black = 0, grown = 0, first = 0, gone = 0;
  for (std::size_t i = 0; i < lit.size(); ++i) {
    black += never_lit_[i] ? 1 : 0;
    grown += never_lit_[i] && lit[i] ? 1 : 0;
    first += first_lit_[i] ? 1 : 0;
    gone += first_lit_[i] && !lit[i] ? 1 : 0;
  }
  if (grown > 0 && static_cast<double>(grown) > kGrown * static_cast<double>(black)) {
    return "the screen of the scanner shows echoes where it was black at first: its sector has "
           "grown or moved";
  }
  if (gone > 0 && static_cast<double>(gone) > kShrunk * static_cast<double>(first)) {
    return "the screen of the scanner is black where its sector began at first: its sector has "
           "shrunk or moved";
  }
  return "";
}

}  // namespace nav::session
