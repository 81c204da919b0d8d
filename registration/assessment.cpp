// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/assessment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "registration/pose_solver.hpp"
#include "registration/starts.hpp"

namespace nav::registration {

double z_score(const Lc2Cost& cost, const SweepPoints& sweep, const Pose& pose, int poses,
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
  // Equal costs everywhere: nothing to tell a pose by.
  if (!(deviation > 0)) return 0;
  return (mean - cost.cost(pose).cost) / deviation;
}

double disagreement_mm(const HalvesProblem& problem, const Pose& start, Halves halves) {
  std::set<int> frames;
  for (const Patch& patch : problem.patches.patches) frames.insert(patch.frame);
  const std::vector<int> order(frames.begin(), frames.end());
  const auto in_second = [&](const Patch& patch) {
    const auto at = std::lower_bound(order.begin(), order.end(), patch.frame) - order.begin();
    const auto rank = static_cast<std::size_t>(at);
    return halves == Halves::kOddEven ? rank % 2 == 1 : 2 * rank >= order.size();
  };
  std::vector<Pose> poses;
  for (const bool second : {false, true}) {
    const PatchSet half =
        subset(problem.patches, [&](const Patch& patch) { return in_second(patch) == second; });
    if (half.patches.size() < kMinPatches) return std::numeric_limits<double>::infinity();
    const Lc2Cost cost(problem.channels, half, problem.ridge, problem.threads);
    poses.push_back(
        solve_pose(cost, start, problem.sweep.centroid, problem.max_iterations, {}).pose);
  }
  return distance_mm(problem.sweep, poses[0], poses[1]);
}

}  // namespace nav::registration
