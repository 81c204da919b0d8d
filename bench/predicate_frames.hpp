// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "bench/measure.hpp"
#include "bench/scene_set.hpp"
#include "render/engine.hpp"

namespace nav::bench {

/// Largest difference in any channel, [0, 1].
inline double largest_difference(const render::RenderedImage& a, const render::RenderedImage& b) {
  float most = 0;
  for (std::size_t i = 0; i < a.pixels.pixels().size(); ++i) {
    const RgbaF& p = a.pixels.pixels()[i];
    const RgbaF& q = b.pixels.pixels()[i];
    most = std::max({most, std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)});
  }
  return most;
}

/// Root mean square of all channels, [0, 1].
inline double rms_difference(const render::RenderedImage& a, const render::RenderedImage& b) {
  double sum = 0;
  const std::size_t count = a.pixels.pixels().size();
  for (std::size_t i = 0; i < count; ++i) {
    const RgbaF& p = a.pixels.pixels()[i];
    const RgbaF& q = b.pixels.pixels()[i];
    for (const double d : {p.r - q.r, p.g - q.g, p.b - q.b}) sum += d * d;
  }
  return std::sqrt(sum / (3.0 * static_cast<double>(count)));
}

/// Draws frames that differ by micrometres, so that each is cast again. cast_s, if not null,
/// receives the device's time for each.
inline Task frames(render::Engine& engine, render::Scene scene, int& frame,
                   std::vector<double>* cast_s = nullptr) {
  return [&engine, scene = std::move(scene), &frame, cast_s]() -> Result<void> {
    const auto image = engine.render(nudged(scene, ++frame));
    if (!image) return image.error();
    if (cast_s != nullptr) cast_s->push_back(image->statistics.cast_s);
    return {};
  };
}

/// Removes bricks and early termination.
inline render::Scene without_tricks(render::Scene scene) {
  scene.predicates->termination_error = 0;
  scene.quality.skip_empty_bricks = false;
  return scene;
}

}  // namespace nav::bench
