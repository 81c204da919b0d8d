// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>

#include "bench/scene_set.hpp"
#include "render/engine.hpp"

namespace nav::bench {

/// Draws a scene on its own CPU engine again and again, with the camera moved a little for each
/// image. Only the ray casting remains, and no part of it can be reused.
class MovingCamera {
 public:
  explicit MovingCamera(render::Scene scene) : scene_(std::move(scene)) {}

  Result<void> draw() { return draw(frame_ + 1); }
  /// Draws the image with this number; draw() continues from it.
  Result<void> draw(int frame) {
    frame_ = frame;
    auto image = engine_->render(nudged(scene_, frame_));
    if (!image) return image.error();
    statistics_ = image->statistics;
    return {};
  }
  /// Statistics of the last image.
  [[nodiscard]] const render::RenderStatistics& statistics() const { return statistics_; }

 private:
  render::Scene scene_;
  std::unique_ptr<render::Engine> engine_ = render::make_cpu_engine();
  render::RenderStatistics statistics_;
  int frame_ = 0;
};

}  // namespace nav::bench
