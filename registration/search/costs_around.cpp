// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/search/costs_around.hpp"

#include <algorithm>

namespace nav::registration {
namespace {

constexpr double kLeastEdgeMm = 10;
constexpr std::size_t kMostAround = 600;

}  // namespace

CostsAround costs_around(const SimilarityCost& cost, const SweepPoints& sweep, const Pose& pose,
                         bool gradients) {
  const std::size_t all = cost.patches().patches.size();
  const std::size_t stride = std::max<std::size_t>((all + kMostAround - 1) / kMostAround, 1);
  std::size_t index = 0;
  const auto kept = [&](const Patch&) { return index++ % stride == 0; };
  const double turn_rad = kAroundMm / std::max(sweep.radius_mm, kLeastEdgeMm);
  CostsAround out{.patches = subset(cost.patches(), kept),
                  .stride = stride,
                  .pose = pose,
                  .turn_rad = turn_rad};
  const SimilarityCost few = cost.on(out.patches);
  out.here = few.cost(pose, true);
  const Eigen::Vector3d centre = (pose * sweep.centroid).mm;
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Vector6d twist = Vector6d::Zero();
      twist[axis] = sign * (axis < 3 ? turn_rad : kAroundMm);
      const Pose there = moved(pose, centre, twist);
      out.beside.push_back(
          {there, gradients ? few.gradient(there, centre, true) : few.cost(there, true)});
    }
  }
  return out;
}

}  // namespace nav::registration
