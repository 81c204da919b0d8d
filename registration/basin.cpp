// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/basin.hpp"

#include <algorithm>
#include <limits>

namespace nav::registration {
namespace {

constexpr double kStepMm = 1;
constexpr double kLeastRadiusMm = 10;
constexpr double kLeastCost = 1e-12;
// More tell no better whether a millimetre costs something.
constexpr std::size_t kMostPatches = 600;

struct Lowest {
  Pose pose;
  double cost;
};

Lowest lowest_about(const Lc2Cost& cost, const SweepPoints& sweep, const Pose& pose) {
  const Eigen::Vector3d centre = (pose * sweep.centroid).mm;
  const double rad = kStepMm / std::max(sweep.radius_mm, kLeastRadiusMm);
  Lowest lowest{pose, std::numeric_limits<double>::infinity()};
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Vector6d twist = Vector6d::Zero();
      twist[axis] = sign * (axis < 3 ? rad : kStepMm);
      const Pose there = moved(pose, centre, twist);
      const double found = cost.cost(there).cost;
      if (found < lowest.cost) lowest = {there, found};
    }
  }
  return lowest;
}

}  // namespace

BasinCheck check_basin(const Lc2Cost& cost, const SweepPoints& sweep, const Pose& pose) {
  const std::size_t stride = (cost.patches().patches.size() + kMostPatches - 1) / kMostPatches;
  std::size_t index = 0;
  const PatchSet some = subset(cost.patches(), [&](const Patch&) {
    return index++ % std::max<std::size_t>(stride, 1) == 0;
  });
  const Lc2Cost few = cost.on(some);
  BasinCheck check;
  Lowest at{pose, few.cost(pose).cost};
  for (int step = 0; step < kBasinSteps; ++step) {
    const Lowest next = lowest_about(few, sweep, at.pose);
    if (step == 0) check.rise = (next.cost - at.cost) / std::max(at.cost, kLeastCost);
    if (!(next.cost < at.cost)) break;
    at = next;
  }
  check.shift_mm = distance_mm(sweep, at.pose, pose);
  return check;
}

}  // namespace nav::registration
