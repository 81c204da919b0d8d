// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/image.hpp"

#include <algorithm>

namespace nav {

Image2d<std::uint8_t> luma(const Image2d<Rgb8>& image) {
  std::vector<std::uint8_t> values;
  values.reserve(image.pixels().size());
  for (const Rgb8& pixel : image.pixels()) values.push_back(luma(pixel));
  return {image.width(), image.height(), std::move(values)};
}

bool has_colours(const Image2d<Rgb8>& image) {
  return std::ranges::any_of(image.pixels(),
                             [](const Rgb8& p) { return p.r != p.g || p.g != p.b; });
}

}  // namespace nav
