// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/registry.hpp"

namespace nav::render {

const PredicateKind& gradient_magnitude_predicate() {
  static const RangePredicate kind(
      "gradient_magnitude", "Magnitude of the brightness gradient, within a range.",
      feature::kGradientMagnitude,
      {{"low_per_mm", "1/mm", 0, 1e6, 0.05}, {"high_per_mm", "1/mm", 0, 1e6, 1e6}});
  return kind;
}

}  // namespace nav::render
