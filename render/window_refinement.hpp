// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace nav::render {

/// Decides when a window draws coarsely: while the camera moves faster than whole pictures can be
/// drawn. Times are seconds on any clock that does not run back. Internal to render/.
class WindowRefinement {
 public:
  /// Pixels of a coarse picture per side, as a fraction: 1 / this.
  static constexpr int kCoarseFactor = 2;
  /// A whole picture that takes no longer than this is never made coarse, s.
  static constexpr double kBudget_s = 0.033;
  /// From the last movement to the whole picture, s: leaves time to draw within 300 ms.
  static constexpr double kStillAfter_s = 0.1;

  explicit WindowRefinement(bool progressive) : progressive_(progressive) {}

  void camera_moved(double now_s) { moved_s_ = now_s; }
  /// How the picture that is drawn now should be.
  [[nodiscard]] int factor(double now_s) const {
    const bool moving = moved_s_ && now_s - *moved_s_ < kStillAfter_s;
    return progressive_ && moving && whole_cost_s_ > kBudget_s ? kCoarseFactor : 1;
  }
  void drawn(int factor, double cost_s) {
    coarse_ = factor > 1;
    if (!coarse_) whole_cost_s_ = cost_s;
  }
  /// What is shown is coarse and need not be any more.
  [[nodiscard]] bool wants_refinement(double now_s) const { return coarse_ && factor(now_s) == 1; }

 private:
  bool progressive_;
  std::optional<double> moved_s_;
  double whole_cost_s_ = 0;
  bool coarse_ = false;
};

}  // namespace nav::render
