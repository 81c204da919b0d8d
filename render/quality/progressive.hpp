// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/time.hpp"
#include "render/engine.hpp"
#include "render/quality/refinement.hpp"

namespace nav::render {

/// Draws coarsely while the scene changes faster than an engine can follow, and in full once the
/// scene is still. A coarse image shows the same scene at the same moment: it gives up only rays
/// and, if that is not enough, resolution. Not thread-safe.
class ProgressiveRenderer {
 public:
  struct ProgressiveImage {
    RenderedImage image;  ///< Has the size of the scene.
    bool refined;         ///< true: has the requested quality.
  };

  /// The engine must outlive this. An invalid option is a Bug.
  ProgressiveRenderer(Engine& engine, const ProgressiveOptions& options = {});

  /// Draws an image of a scene. now: time of the request, on any clock that does not run backwards.
  Result<ProgressiveImage> draw(const Scene& scene, Timestamp now);
  /// True if the last image was coarse and no other event makes the next call draw: call draw()
  /// again.
  [[nodiscard]] bool wants_refinement() const { return refinement_.wants_refinement(); }
  /// True if, in addition, it would now be drawn in full.
  [[nodiscard]] bool wants_refinement(Timestamp now) const {
    return refinement_.wants_refinement(now);
  }

 private:
  Engine& engine_;
  Refinement refinement_;
};

/// Enlarges an image with fewer pixels to the size of the scene: bilinear between the positions of
/// its rays.
RenderedImage enlarged(const RenderedImage& coarse, int width, int height);

}  // namespace nav::render
