// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "nav/check.hpp"

namespace nav {

/// 2D image that owns its pixels; row-major, top row first. A copy shares the pixels, which do not
/// change once shared. Reading is thread-safe.
template <class T>
class Image2d {
 public:
  Image2d() = default;
  /// Precondition: pixels.size() == width * height, otherwise a Bug.
  Image2d(int width, int height, std::vector<T> pixels)
      : Image2d(shared(width, height, std::make_shared<const std::vector<T>>(std::move(pixels)))) {}
  /// Shares pixels that no longer change. Preconditions: the size as above, and not null.
  static Image2d shared(int width, int height, std::shared_ptr<const std::vector<T>> pixels) {
    NAV_CHECK(width >= 0 && height >= 0, width, height);
    NAV_CHECK(pixels->size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
              pixels->size(), width, height);
    Image2d image;
    image.width_ = width;
    image.height_ = height;
    image.pixels_ = std::move(pixels);
    return image;
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool empty() const { return width_ == 0 || height_ == 0; }
  [[nodiscard]] std::span<const T> pixels() const {
    return pixels_ ? std::span<const T>(*pixels_) : std::span<const T>();
  }
  [[nodiscard]] const T& at(int column, int row) const {
    NAV_CHECK(column >= 0 && column < width_ && row >= 0 && row < height_, column, row);
    return (*pixels_)[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                      static_cast<std::size_t>(column)];
  }

 private:
  int width_ = 0;
  int height_ = 0;
  std::shared_ptr<const std::vector<T>> pixels_;
};

/// 8-bit colour with straight alpha, as PNG stores it.
struct Rgba8 {
  std::uint8_t r, g, b, a;
  friend bool operator==(const Rgba8&, const Rgba8&) = default;
};

/// 8-bit colour without alpha, as scanners and video give it.
struct Rgb8 {
  std::uint8_t r, g, b;
  friend bool operator==(const Rgb8&, const Rgb8&) = default;
};
static_assert(sizeof(Rgb8) == 3);

/// Brightness of a colour (luma of ITU-R BT.601), rounded; a grey keeps its value.
constexpr std::uint8_t luma(const Rgb8& c) {
  return static_cast<std::uint8_t>((299U * c.r + 587U * c.g + 114U * c.b + 500U) / 1000U);
}
/// Brightness of every pixel.
Image2d<std::uint8_t> luma(const Image2d<Rgb8>& image);
/// True if a pixel is not grey.
bool has_colours(const Image2d<Rgb8>& image);

/// Single-precision colour, premultiplied by alpha, linear in the transfer function's space.
struct RgbaF {
  float r, g, b, a;
};

}  // namespace nav
