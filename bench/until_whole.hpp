// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <thread>

#include "nav/time.hpp"
#include "render/quality/progressive.hpp"

namespace nav::bench {

/// Draws images of a scene until one is complete, at the rate at which a viewer requests them.
inline Result<void> draw_until_whole(render::ProgressiveRenderer& renderer,
                                     const render::Scene& scene, const Clock& clock) {
  constexpr auto kRefresh = std::chrono::milliseconds(5);
  while (true) {
    const auto image = renderer.draw(scene, clock.now());
    if (!image) return image.error();
    if (!renderer.wants_refinement()) return {};
    std::this_thread::sleep_for(kRefresh);
  }
}

}  // namespace nav::bench
