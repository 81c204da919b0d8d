// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/time.hpp"
#include "render/engine.hpp"
#include "render/quality/refinement.hpp"

namespace nav::render {

/// Draws coarsely while the scene changes faster than an engine can follow, and in full once it is
/// still. A coarse picture shows the same scene at the same moment: only rays and, where they are
/// not enough, resolution are given up. Not thread-safe.
class ProgressiveRenderer {
 public:
  struct Picture {
    RenderedImage image;  ///< Of the size of the scene.
    bool refined;         ///< Of the quality that was asked for.
  };

  /// The engine must outlive this. A bad option is a Bug.
  ProgressiveRenderer(Engine& engine, const ProgressiveOptions& options = {});

  /// The picture of a scene. now: when it is asked for, on any clock that does not run back.
  Result<Picture> draw(const Scene& scene, Timestamp now);
  /// The last picture was coarse, and nothing else would make the next call draw: ask again.
  [[nodiscard]] bool wants_refinement() const { return refinement_.wants_refinement(); }

 private:
  Engine& engine_;
  Refinement refinement_;
};

/// A picture drawn with fewer pixels, brought to the size of the scene: bilinear between the places
/// where its rays were.
RenderedImage enlarged(const RenderedImage& coarse, int width, int height);

}  // namespace nav::render
