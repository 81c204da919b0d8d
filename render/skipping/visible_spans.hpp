// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "render/scene.hpp"
#include "render/skipping/brick_grid.hpp"
#include "render/spec/ray_spec_volume.hpp"

namespace nav::render {

/// The distances between which the rays of a square of pixels may meet something visible, mm from
/// their origins. Empty if far <= near. The default is the whole ray.
struct VisibleSpan {
  float near = 0;
  float far = std::numeric_limits<float>::infinity();
  [[nodiscard]] bool empty() const { return !(far > near); }
};

/// The occupied bricks of a volume that rays from outside can meet first or last.
struct BrickShell {
  Eigen::Vector3i count = Eigen::Vector3i::Zero();  ///< See BrickGrid::count.
  std::vector<int> bricks;  ///< Those with a face to the outside or to an unoccupied brick.
};
/// Finds the shell on at most this many threads; 0: all cores.
BrickShell brick_shell(const BrickGrid& bricks, const std::vector<std::uint8_t>& hidden,
                       int threads = 0);

/// A VisibleSpan for every square of kSide pixels of an image, from the projected balls around the
/// bricks of the shell. Nothing is visible outside a span. So rays begin and end at its limits and
/// test no brick on the way there, and rays of empty squares are not cast.
class VisibleSpans {
 public:
  static constexpr int kSide = 8;

  /// Projects the shell of the scene's volume on at most this many threads; 0: all cores.
  VisibleSpans(const Scene& scene, const BrickShell& shell, int threads);
  /// True if the spans save more than they cost.
  static bool worth(const Scene& scene, const BrickShell& shell);

  /// The span of the square that holds a pixel of the image.
  [[nodiscard]] VisibleSpan at(int x, int y) const {
    return spans_[static_cast<std::size_t>(y / kSide) * static_cast<std::size_t>(across_) +
                  static_cast<std::size_t>(x / kSide)];
  }

 private:
  int across_;
  int down_;
  std::vector<VisibleSpan> spans_;
};

}  // namespace nav::render
