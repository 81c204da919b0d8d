// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/registry.hpp"

namespace nav::render {

const PredicateKind& gradient_magnitude_predicate() {
  static const RangePredicate kind(
      "gradient_magnitude", "Magnitude of the brightness gradient, within a range.",
      feature::kGradientMagnitude,
      {{.name = "low_per_mm", .unit = "1/mm", .low = 0, .high = 1e6, .initial = 0.05},
       {.name = "high_per_mm", .unit = "1/mm", .low = 0, .high = 1e6, .initial = 1e6}});
  return kind;
}

}  // namespace nav::render
