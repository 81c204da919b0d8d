// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "nav/time.hpp"
#include "render/engine.hpp"

namespace nav::render {

/// When a picture may be coarse.
struct ProgressiveOptions {
  double budget_s = 0.033;  ///< A whole picture that is expected to take no longer is never made
                            ///< coarse; >= 0.
  /// quality.pixel_error of coarse pictures, in [0, 1]; 0: as the scene says.
  double coarse_pixel_error = 0.1;
  /// Where that is not enough, they have 1 / this of the pixels per side, in [2, 8].
  int coarse_factor = 2;
  /// And where that takes longer than the budget, down to 1 / this, in [coarse_factor, 8].
  int largest_factor = 4;
  double refine_after_s = 0.1;  ///< Without a change of anything but ultrasound pixels; >= 0.
};

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
  [[nodiscard]] bool wants_refinement() const { return last_ && !refined_; }

 private:
  [[nodiscard]] bool may_be_coarse(const Scene& scene, Timestamp now);
  [[nodiscard]] double& cost_of(const Scene& scene);
  [[nodiscard]] int small_factor() const;

  Engine& engine_;
  ProgressiveOptions options_;
  std::optional<Scene> last_;   ///< As asked for.
  std::optional<Scene> drawn_;  ///< As the engine drew it.
  bool refined_ = false;
  Timestamp changed_{};
  /// What the last whole picture took, by how much it differed from the picture before.
  std::array<double, 4> cost_s_{};
  double sparse_share_ = 0;  ///< Of that, what fewer rays took; 0: not known.
  /// What the last picture with fewer pixels took, and 1 / its pixels per side.
  double small_s_ = 0;
  int drawn_factor_ = 1;
};

/// A picture drawn with fewer pixels, brought to the size of the scene: bilinear between the places
/// where its rays were.
RenderedImage enlarged(const RenderedImage& coarse, int width, int height);

}  // namespace nav::render
