// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "nav/transform.hpp"

namespace nav::sim {

/// Shape of a needle in the patient, as an image shows it: a chain of straight pieces from the tip
/// backwards. Empty: there is no needle.
class NeedleShaft {
 public:
  NeedleShaft() = default;
  /// \p points_ct: points of the shaft, tip first, in the CT coordinates of the image poses; none
  /// or at least two.
  explicit NeedleShaft(std::vector<Point<frames::Ct>> points_ct) : points_(std::move(points_ct)) {}
  /// Straight needle of 150 mm. The conversion is implicit, because a tracker shows a straight
  /// needle.
  NeedleShaft(const Transform<frames::Ct, frames::Needle>& ct_from_needle)
      : points_{ct_from_needle * Point<frames::Needle>{{0, 0, 0}},
                ct_from_needle * Point<frames::Needle>{{0, 0, -150}}} {}
  NeedleShaft(const std::optional<Transform<frames::Ct, frames::Needle>>& ct_from_needle) {
    if (ct_from_needle) *this = NeedleShaft(*ct_from_needle);
  }

  [[nodiscard]] const std::vector<Point<frames::Ct>>& points_ct() const { return points_; }

 private:
  std::vector<Point<frames::Ct>> points_;
};

}  // namespace nav::sim
