// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "nav/transform.hpp"
#include "sim/anatomy/anatomy.hpp"

namespace nav::sim {

/// Unit outward direction near the skin: the gradient of the skin distance over a footprint of \p
/// footprint_mm to each side, > 0.
Eigen::Vector3d outward(const Anatomy& patient, const Eigen::Vector3d& at_ct_mm,
                        double footprint_mm);

/// Positions of a probe that slides over the skin perpendicular to its image plane, without the
/// hand's involuntary movement. Its depth in the skin and its angle to the skin stay as at the
/// start. The skin is averaged over the probe's footprint, 8 mm to each side. Poses are computed
/// every millimetre and interpolated. Reading is thread-safe.
class SkinTrack {
 public:
  using Pose = Transform<frames::Ct, frames::Image>;
  /// \p reach_mm: length of the track to each side of the start, >= 0.
  SkinTrack(const Anatomy& patient, const Pose& start, double reach_mm);
  /// \p along_mm: distance on the skin, positive along the image's z; clamped to the reach.
  [[nodiscard]] Pose at(double along_mm) const;

 private:
  std::vector<Pose> poses_;  ///< Evenly spaced from one end to the other.
  double reach_mm_;
};

}  // namespace nav::sim
