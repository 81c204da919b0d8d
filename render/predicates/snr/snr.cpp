// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/registry.hpp"

namespace nav::render {

const PredicateKind& snr_predicate() {
  // Features end at 1000 (derived_features.hpp), so a greater upper limit has no effect.
  static const RangePredicate kind(
      "snr", "Signal-to-noise ratio of the neighbourhood, within a range.", feature::kSnr,
      {{.name = "low", .unit = "1", .low = -1e6, .high = 1e3, .initial = 2},
       {.name = "high", .unit = "1", .low = -1e6, .high = 1e6, .initial = 1e6}});
  return kind;
}

}  // namespace nav::render
