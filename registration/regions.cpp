// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/regions.hpp"

#include <algorithm>
#include <array>
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

/// Region index of each patch.
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

struct Region {
  int patches = 0;
  Eigen::Vector3d middle_mm = Eigen::Vector3d::Zero();  ///< Sum of the patch centres, Reference.
  std::vector<std::size_t> members;  ///< Patches whose costs about the pose are known.
};

/// Cost of the patches of one region at the pose, and one step back and forth along each axis.
struct RegionCosts {
  double here = 0;
  std::array<std::array<double, 2>, 3> beside{};
};

double share_of(const std::vector<double>& costs, const PatchSet& set,
                const std::vector<std::size_t>& members) {
  double cost = 0;
  double weight = 0;
  for (const std::size_t i : members) {
    cost += costs[i];
    weight += set.patches[i].weight;
  }
  return weight > 0 ? cost / weight : 0;
}

RegionCosts costs_of(const CostsAround& around, const std::vector<std::size_t>& members) {
  RegionCosts out;
  out.here = share_of(around.here.patch_costs, around.patches, members);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t side = 0; side < 2; ++side) {
      const CostTerms& terms = around.shifted(axis, side).terms;
      out.beside[axis][side] = share_of(terms.patch_costs, around.patches, members);
    }
  }
  return out;
}

/// Costs of a region with a similarity that has no terms of single patches: the cost of its patches
/// together.
RegionCosts costs_of_all(const CostsAround& around, const SimilarityCost& cost,
                         const std::vector<std::size_t>& members) {
  std::size_t index = 0;
  const PatchSet patches = subset(around.patches, [&](const Patch&) {
    return std::binary_search(members.begin(), members.end(), index++);
  });
  const SimilarityCost of_region = cost.on(patches);
  RegionCosts out;
  out.here = of_region.cost(around.pose).cost;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t side = 0; side < 2; ++side) {
      out.beside[axis][side] = of_region.cost(around.shifted(axis, side).pose).cost;
    }
  }
  return out;
}

/// RegionAgreement::pull_mm: distance to the minima of the parabolas along the axes.
double pull_mm(const RegionCosts& costs) {
  constexpr double kFarthestMm = 2 * kAroundMm;
  double squares = 0;
  for (const auto& [before, after] : costs.beside) {
    const double bend = before - 2 * costs.here + after;
    if (!(bend > 0)) continue;
    const double lowest = kAroundMm * 0.5 * (before - after) / bend;
    const double held = std::clamp(lowest, -kFarthestMm, kFarthestMm);
    squares += held * held;
  }
  return std::sqrt(squares);
}

}  // namespace

std::vector<RegionAgreement> region_agreement(const CostsAround& around,
                                              const SimilarityCost& cost) {
  const PatchSet& all = cost.patches();
  std::array<Region, kRegions> regions;
  const std::vector<std::size_t> region_of = regions_of(all);
  for (std::size_t i = 0; i < region_of.size(); ++i) {
    Region& region = regions[region_of[i]];
    region.middle_mm += all.patches[i].centre_mm;
    ++region.patches;
    if (i % around.stride == 0) region.members.push_back(i / around.stride);
  }
  std::vector<RegionAgreement> out;
  for (std::size_t r = 0; r < kRegions; ++r) {
    const Region& region = regions[r];
    if (region.members.empty()) continue;
    const RegionCosts costs = around.here.patch_costs.empty()
                                  ? costs_of_all(around, cost, region.members)
                                  : costs_of(around, region.members);
    out.push_back(
        {.along = static_cast<int>(r) / kThirds,
         .deep = static_cast<int>(r) % kThirds,
         .patches = region.patches,
         .cost = costs.here,
         .pull_mm = pull_mm(costs),
         .centre = around.pose * Point<frames::Reference>{region.middle_mm / region.patches}});
  }
  return out;
}

}  // namespace nav::registration
