// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "nav/time.hpp"
#include "render/engine.hpp"
#include "render/quality/refinement.hpp"
#include "render/quality/thin_scenes.hpp"

namespace nav::render {

/// An engine of its own for coarse images, which it draws of every second voxel. So each engine
/// keeps the data of its own volume.
struct CoarseEngine {
  Engine& engine;
  ThinScenes scenes{};
};

/// Draws coarsely while the scene changes faster than an engine can follow, and in full once the
/// scene is still. A coarse image shows the same scene at the same moment: it gives up only rays
/// and, if that is not enough, resolution. Not thread-safe.
class ProgressiveRenderer {
 public:
  struct ProgressiveImage {
    RenderedImage image;  ///< Has the size of the scene.
    bool refined;         ///< true: has the requested quality.
    int factor;           ///< 1 / factor of the pixels per side were drawn, and enlarged.
  };

  /// The engines must outlive this. An invalid option is a Bug. \p coarse: draws coarse images, and
  /// may be shared with others; null: the first engine draws them, of all voxels.
  ProgressiveRenderer(Engine& engine, const ProgressiveOptions& options = {},
                      CoarseEngine* coarse = nullptr);

  /// Tells the change from the scene that is drawn to a newer one that waits; kNothing: none waits.
  /// Called from all threads of the engine, some thousand times per image.
  using Newer = std::function<SceneChange()>;

  /// Draws an image of a scene. now: time of the request, on any clock that does not run backwards.
  /// An image that takes longer than the budget is given up (kCancelled) for a newer scene that
  /// looks different. A coarse image is finished, unless it is the first of its kind.
  Result<ProgressiveImage> draw(const Scene& scene, Timestamp now, const Newer& newer = {});
  /// draw() for callers that enlarge the image themselves (EnlargedRows): a coarse image keeps the
  /// size in which it was drawn.
  Result<ProgressiveImage> draw_small(const Scene& scene, Timestamp now, const Newer& newer = {});
  /// Changes ProgressiveOptions::budget_s, >= 0.
  void set_budget(double budget_s) { refinement_.set_budget(budget_s); }
  /// True if the last image was coarse and no other event makes the next call draw: call draw()
  /// again.
  [[nodiscard]] bool wants_refinement() const { return refinement_.wants_refinement(); }
  /// True if, in addition, it would now be drawn in full.
  [[nodiscard]] bool wants_refinement(Timestamp now) const {
    return refinement_.wants_refinement(now);
  }

 private:
  Engine& engine_;
  CoarseEngine* coarse_;
  Refinement refinement_;
};

/// The rows of an image with fewer pixels, enlarged to the size of the scene: bilinear between the
/// positions of its rays. Thread-safe.
class EnlargedRows {
 public:
  /// The image must outlive it.
  EnlargedRows(const Image2d<RgbaF>& coarse, int width, int height);
  /// Writes a row. \p between: working data, kept from row to row.
  void write(int y, std::vector<RgbaF>& between, RgbaF* row) const;

 private:
  /// A position between two pixels of the coarse image along one axis; w: weight of the second.
  struct Pair {
    int low;
    int high;
    float w;
  };
  static Pair pair_of(int full, int full_count, int coarse_count, double scale);

  const Image2d<RgbaF>& coarse_;
  int height_;
  double scale_;  ///< Pixels of the coarse image per pixel.
  std::vector<Pair> columns_;
};

/// An image with fewer pixels in the size of the scene.
RenderedImage enlarged(const RenderedImage& coarse, int width, int height);

}  // namespace nav::render
