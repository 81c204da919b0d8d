// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>

#include "bench/scene_set.hpp"
#include "render/engine.hpp"

namespace nav::bench {

/// Draws a scene on its own CPU engine again and again, each frame a little moved, so that nothing
/// but the casting is left to do and none of it can be left out.
class MovingCamera {
 public:
  explicit MovingCamera(render::Scene scene) : scene_(std::move(scene)) {}

  Result<void> draw() { return draw(frame_ + 1); }
  /// The frame of a number; draw() goes on from there.
  Result<void> draw(int frame) {
    frame_ = frame;
    auto image = engine_->render(nudged(scene_, frame_));
    if (!image) return image.error();
    statistics_ = image->statistics;
    return {};
  }
  /// Of the last frame.
  [[nodiscard]] const render::RenderStatistics& statistics() const { return statistics_; }

 private:
  render::Scene scene_;
  std::unique_ptr<render::Engine> engine_ = render::make_cpu_engine();
  render::RenderStatistics statistics_;
  int frame_ = 0;
};

}  // namespace nav::bench
