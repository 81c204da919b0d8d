// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/reslice.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace nav::render {

Image2d<Rgba8> reslice(const Volume& ct, const Transform<frames::Ct, frames::Image>& ct_from_image,
                       const Eigen::Vector2d& origin_mm, double mm_per_pixel, int width, int height,
                       const HuWindow& window) {
  NAV_CHECK(origin_mm.allFinite() && mm_per_pixel > 0 && window.width > 0, mm_per_pixel,
            window.width);
  std::vector<Rgba8> pixels;
  pixels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const Eigen::Vector2d p = origin_mm + mm_per_pixel * Eigen::Vector2d(column, row);
      const auto hu = ct.sample(ct_from_image * Point<frames::Image>{{p.x(), p.y(), 0}});
      if (!hu) {
        pixels.push_back({0, 0, 0, 0});
        continue;
      }
      const double grey = std::clamp((*hu - window.level) / window.width + 0.5, 0.0, 1.0);
      const auto value = static_cast<std::uint8_t>(std::lround(255 * grey));
      pixels.push_back({value, value, value, 255});
    }
  }
  return {width, height, std::move(pixels)};
}

}  // namespace nav::render
