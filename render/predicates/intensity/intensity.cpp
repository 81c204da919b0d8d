// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/registry.hpp"

namespace nav::render {

const PredicateKind& intensity_predicate() {
  static const RangePredicate kind(
      "intensity", "Brightness as a share of white, within a range.", feature::kIntensity,
      {{.name = "low", .unit = "1", .low = -1e6, .high = 1e6, .initial = 0.2},
       {.name = "high", .unit = "1", .low = -1e6, .high = 1e6, .initial = 1e6}});
  return kind;
}

}  // namespace nav::render
