// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "nav/transform.hpp"
#include "sim/anatomy/anatomy.hpp"

namespace nav::sim {

/// Out of the patient, unit, where the skin is near: the slope of its distance over a footprint of
/// so many mm to each side, > 0.
Eigen::Vector3d outward(const Anatomy& patient, const Eigen::Vector3d& at_ct_mm,
                        double footprint_mm);

/// Where a probe is that slides over the skin across its picture's plane, without a hand's wobble:
/// as deep in the skin, and at the same angle to it, as at the start. What the skin is counts over
/// the probe's footprint, 8 mm to each side. Poses every millimetre, interpolated between.
/// Thread-safe to read.
class SkinTrack {
 public:
  using Pose = Transform<frames::Ct, frames::Image>;
  /// reach_mm >= 0: how far it is known to each side of the start.
  SkinTrack(const Anatomy& patient, const Pose& start, double reach_mm);
  /// along_mm: way on the skin, positive along the picture's z; clamped to the reach.
  [[nodiscard]] Pose at(double along_mm) const;

 private:
  std::vector<Pose> poses_;  ///< Evenly from one end to the other.
  double reach_mm_;
};

}  // namespace nav::sim
