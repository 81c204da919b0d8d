// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/registry.hpp"

namespace nav::render {

const PredicateKind& confidence_predicate() {
  static const RangePredicate kind(
      "confidence", "Share of the ultrasound that reaches the voxel, within a range.",
      feature::kConfidence,
      {{.name = "low", .unit = "1", .low = 0, .high = 1, .initial = 0.3},
       {.name = "high", .unit = "1", .low = 0, .high = 1, .initial = 1}});
  return kind;
}

}  // namespace nav::render
