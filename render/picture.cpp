// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "render/engine.hpp"

namespace nav::render {

Image2d<Rgba8> to_8bit(const Image2d<RgbaF>& pixels) {
  const auto byte = [](float x) {
    return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(x, 0.0F, 1.0F)));
  };
  std::vector<Rgba8> out;
  out.reserve(pixels.pixels().size());
  for (const RgbaF& p : pixels.pixels())
    out.push_back({byte(p.r), byte(p.g), byte(p.b), byte(p.a)});
  return {pixels.width(), pixels.height(), std::move(out)};
}

}  // namespace nav::render
