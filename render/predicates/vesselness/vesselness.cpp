// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/registry.hpp"

namespace nav::render {

const PredicateKind& vesselness_predicate() {
  static const RangePredicate kind(
      "vesselness", "Frangi's measure of a tube, within a range.", feature::kVesselness,
      {{.name = "low", .unit = "1", .low = 0, .high = 1, .initial = 0.1},
       {.name = "high", .unit = "1", .low = 0, .high = 1, .initial = 1}});
  return kind;
}

}  // namespace nav::render
