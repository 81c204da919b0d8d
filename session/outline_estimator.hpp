// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "nav/sweep.hpp"

namespace nav::session {

/// Learns the sector that the images of a convex probe show, from the images so far. It starts
/// unknown, decides once, after 10 to 80 images (two estimates, the second from twice as many
/// images, must agree), and then stays; a change of the image size starts it again. Images of a
/// linear probe have no sector. Not thread-safe.
class OutlineEstimator {
 public:
  void add(const UltrasoundImage& image);
  [[nodiscard]] const std::optional<SectorOutline>& outline() const { return outline_; }
  /// Images that the decision took; absent while it is open.
  [[nodiscard]] std::optional<std::size_t> decided_after() const { return decided_after_; }

 private:
  void estimate();

  std::vector<TrackedImage> images_;  ///< All images until the decision.
  std::size_t next_ = kFirst;
  std::optional<SectorOutline> previous_, outline_;
  std::optional<std::size_t> decided_after_;
  int width_ = 0, height_ = 0;

  static constexpr std::size_t kFirst = 5;
  static constexpr std::size_t kMost = 80;
};

}  // namespace nav::session
