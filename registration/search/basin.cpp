// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/search/basin.hpp"

#include <algorithm>
#include <limits>

namespace nav::registration {
namespace {

constexpr double kLeastBasinCost = 1e-12;

struct Lowest {
  Pose pose;
  double cost;
};

Lowest lowest_of(const CostsAround& around) {
  Lowest lowest{around.pose, std::numeric_limits<double>::infinity()};
  for (const auto& [pose, terms] : around.beside) {
    if (terms.cost < lowest.cost) lowest = {pose, terms.cost};
  }
  return lowest;
}

}  // namespace

BasinCheck check_basin(const CostsAround& around, const SimilarityCost& cost,
                       const SweepPoints& sweep) {
  BasinCheck check;
  Lowest at{around.pose, around.here.cost};
  Lowest next = lowest_of(around);
  check.rise = (next.cost - at.cost) / std::max(at.cost, kLeastBasinCost);
  for (int step = 1; next.cost < at.cost; ++step) {
    at = next;
    if (step == kBasinSteps) break;
    next = lowest_of(costs_around(cost, sweep, at.pose));
  }
  check.shift_mm = distance_mm(sweep, at.pose, around.pose);
  return check;
}

}  // namespace nav::registration
