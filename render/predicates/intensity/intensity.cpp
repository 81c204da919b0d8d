// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/registry.hpp"

namespace nav::render {

const PredicateKind& intensity_predicate() {
  static const RangePredicate kind("intensity", "Brightness as a share of white, within a range.",
                                   feature::kIntensity,
                                   {{"low", "1", -1e6, 1e6, 0.2}, {"high", "1", -1e6, 1e6, 1e6}});
  return kind;
}

}  // namespace nav::render
