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

/// Between which distances the rays of a square of pixels may meet something visible, mm from
/// their origins; empty when far <= near.
/// Unless said, the whole ray.
struct VisibleSpan {
  float near = 0;
  float far = std::numeric_limits<float>::infinity();
  [[nodiscard]] bool empty() const { return !(far > near); }
};

/// The occupied bricks of a volume, as far as rays from outside of it can meet them first or last.
struct BrickShell {
  Eigen::Vector3i count = Eigen::Vector3i::Zero();  ///< As BrickGrid::count.
  std::vector<int>
      bricks;  ///< Those with a face to the outside or to a brick that is not occupied.
};
/// Uses at most threads threads; 0: all cores.
BrickShell brick_shell(const BrickGrid& bricks, const std::vector<std::uint8_t>& hidden,
                       int threads = 0);

/// A VisibleSpan for every square of kSide pixels of a picture: the balls around the bricks of the
/// shell, projected. What a span leaves out can show nothing, so that rays that begin
/// and end there look at no brick on their way to it, and those of empty squares are not cast.
class VisibleSpans {
 public:
  static constexpr int kSide = 8;

  /// shell: of the scene's volume. Uses at most threads threads; 0: all cores.
  VisibleSpans(const Scene& scene, const BrickShell& shell, int threads);
  /// Whether they save more than they cost.
  static bool worth(const Scene& scene, const BrickShell& shell);

  /// Of the square that holds a pixel of the picture.
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
