// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "render/engine.hpp"
#include "render/interruptible.hpp"

namespace nav::render {

Error interrupted_error(const std::string& engine) {
  return {ErrorCode::kCancelled, engine + " engine: the image was interrupted"};
}

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

double rms_difference(const Image2d<RgbaF>& a, const Image2d<RgbaF>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < b.pixels().size(); ++i) {
    const RgbaF& p = a.pixels()[i];
    const RgbaF& q = b.pixels()[i];
    sum += std::pow(p.r - q.r, 2) + std::pow(p.g - q.g, 2) + std::pow(p.b - q.b, 2);
  }
  return std::sqrt(sum / (3.0 * static_cast<double>(b.pixels().size())));
}

}  // namespace nav::render
