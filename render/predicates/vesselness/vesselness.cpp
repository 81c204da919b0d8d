// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/registry.hpp"

namespace nav::render {

const PredicateKind& vesselness_predicate() {
  static const RangePredicate kind("vesselness", "Frangi's measure of a tube, within a range.",
                                   feature::kVesselness,
                                   {{"low", "1", 0, 1, 0.1}, {"high", "1", 0, 1, 1}});
  return kind;
}

}  // namespace nav::render
