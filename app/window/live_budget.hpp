// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "nav/time.hpp"

namespace nav::app {

/// Time for the rays of an image of the 3D view while ultrasound is live: what remains of the time
/// between two moments, so that every moment is shown. One thread; times are arguments.
class LiveBudget {
 public:
  /// Before anything is known, s.
  static constexpr double kFirst = 0.020;
  /// With less, images of a busy machine would show nothing any more, s.
  static constexpr double kLeast = 0.015;
  /// With more, the view would follow the mouse too slowly, s.
  static constexpr double kMost = 0.045;

  /// A moment was ordered. \p number: Moment::number. \p published: when it was made.
  void ordered(std::uint64_t number, Timestamp published);
  /// An image was made. \p rays_s: time of its rays; \p whole_s: from its order to the end, with
  /// preparation, enlargement and conversion.
  void drawn(double rays_s, double whole_s);
  /// Time for the rays of the next image, s.
  [[nodiscard]] double budget_s() const;

 private:
  struct Seen {
    std::uint64_t number;
    Timestamp published;
  };
  std::optional<Seen> last_;
  std::optional<double> interval_s_;
  double besides_s_ = 0;  ///< Time of an image besides its rays.
};

}  // namespace nav::app
