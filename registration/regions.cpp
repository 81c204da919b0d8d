// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/regions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nav/index.hpp"

namespace nav::registration {
namespace {

constexpr int kThirds = 3;
constexpr std::size_t kRegions = kThirds * kThirds;

int third_of(double value, double low, double high) {
  if (!(high > low)) return 0;
  return std::clamp(static_cast<int>(kThirds * (value - low) / (high - low)), 0, kThirds - 1);
}

/// Region of each patch.
std::vector<std::size_t> regions_of(const PatchSet& set) {
  std::vector<int> frames;
  double shallow = std::numeric_limits<double>::infinity();
  double deep = -shallow;
  for (const Patch& patch : set.patches) {
    frames.push_back(patch.frame);
    shallow = std::min(shallow, patch.depth_mm);
    deep = std::max(deep, patch.depth_mm);
  }
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  std::vector<std::size_t> regions;
  for (const Patch& patch : set.patches) {
    const auto rank = std::lower_bound(frames.begin(), frames.end(), patch.frame) - frames.begin();
    const int along = third_of(static_cast<double>(rank), 0, static_cast<double>(frames.size()));
    regions.push_back(as_size(kThirds * along + third_of(patch.depth_mm, shallow, deep)));
  }
  return regions;
}

/// RegionAgreement::pull_mm of the patches of a cost.
double pull_mm(const Lc2Cost& cost, const Pose& pose, double here) {
  constexpr double kStepMm = 2;
  double squares = 0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto beside = [&](double mm) {
      const Eigen::Vector3d shift = mm * Eigen::Vector3d::Unit(axis);
      return cost.cost(Pose(pose.rotation(), pose.translation_mm() + shift)).cost;
    };
    const double before = beside(-kStepMm);
    const double after = beside(kStepMm);
    const double bend = before - 2 * here + after;
    if (!(bend > 0)) continue;
    const double lowest = kStepMm * 0.5 * (before - after) / bend;
    const double held = std::clamp(lowest, -kStepMm, kStepMm);
    squares += held * held;
  }
  return std::sqrt(squares);
}

}  // namespace

std::vector<RegionAgreement> region_agreement(const Lc2Cost& cost, const Pose& pose) {
  const PatchSet& set = cost.patches();
  const std::vector<std::size_t> regions = regions_of(set);
  std::vector<RegionAgreement> out;
  for (std::size_t r = 0; r < kRegions; ++r) {
    std::size_t index = 0;
    const PatchSet here = subset(set, [&](const Patch&) { return regions[index++] == r; });
    if (here.patches.empty()) continue;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Patch& patch : here.patches) middle += patch.centre_mm;
    middle /= static_cast<double>(here.patches.size());
    const Lc2Cost of_region = cost.on(here);
    const double found = of_region.cost(pose).cost;
    out.push_back({static_cast<int>(r) / kThirds, static_cast<int>(r) % kThirds,
                   static_cast<int>(here.patches.size()), found, pull_mm(of_region, pose, found),
                   pose * Point<frames::Reference>{middle}});
  }
  return out;
}

}  // namespace nav::registration
