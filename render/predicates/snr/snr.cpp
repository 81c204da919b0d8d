// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/registry.hpp"

namespace nav::render {

const PredicateKind& snr_predicate() {
  // Features end at 1000 (derived_features.hpp), so a greater upper limit has no effect.
  static const RangePredicate kind(
      "snr", "Signal-to-noise ratio of the neighbourhood, within a range.", feature::kSnr,
      {{"low", "1", -1e6, 1e3, 2}, {"high", "1", -1e6, 1e6, 1e6}});
  return kind;
}

}  // namespace nav::render
