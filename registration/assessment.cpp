// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/assessment.hpp"

#include <cmath>
#include <vector>

#include "registration/search/starts.hpp"

namespace nav::registration {

double z_score(const SimilarityCost& cost, const SweepPoints& sweep, const Pose& pose, int poses,
               std::uint64_t seed) {
  const Eigen::Vector3d centre = (pose * sweep.centroid).mm;
  std::vector<double> costs;
  for (const Vector6d& twist : spread_twists(poses, kRandomPoseRad, kRandomPoseMm, seed)) {
    costs.push_back(cost.cost(moved(pose, centre, twist)).cost);
  }
  const auto n = static_cast<double>(costs.size());
  double mean = 0;
  for (const double value : costs) mean += value / n;
  double variance = 0;
  for (const double value : costs) variance += (value - mean) * (value - mean) / (n - 1);
  const double deviation = std::sqrt(variance);
  // Equal costs everywhere give no information about a pose.
  if (!(deviation > 0)) return 0;
  return (mean - cost.cost(pose).cost) / deviation;
}

}  // namespace nav::registration
