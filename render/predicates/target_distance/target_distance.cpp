// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/registry.hpp"

namespace nav::render {
namespace {

/// Tests the distance from the target's surface, which is negative inside.
class TargetDistance final : public PredicateKind {
 public:
  [[nodiscard]] std::string name() const override { return "target_distance"; }
  [[nodiscard]] std::string description() const override {
    return "Distance from the target's surface, within a range; negative inside.";
  }
  [[nodiscard]] std::vector<PredicateParameter> parameters() const override {
    return {{.name = "low_mm", .unit = "mm", .low = -1e4, .high = 1e4, .initial = -1e4},
            {.name = "high_mm", .unit = "mm", .low = -1e4, .high = 1e4, .initial = 10}};
  }
  [[nodiscard]] PredicateNeeds needs(const PredicatePosition&) const override {
    PredicateNeeds needs;
    needs.position = true;
    needs.target = true;
    return needs;
  }
  [[nodiscard]] Result<void> check(std::span<const double> p) const override {
    return check_order(*this, p, 0, 1);
  }
  [[nodiscard]] bool test(const PredicateSample& s, const PredicatePosition& place,
                          std::span<const double> p) const override {
    return test_distance(*place.target, s.position_mm, wanted_range(p));
  }
  [[nodiscard]] Truth bounds(const PredicateBounds& b, const PredicatePosition& place,
                             std::span<const double> p) const override {
    return bound_distance(*place.target, b.low_mm, b.high_mm, wanted_range(p));
  }
  [[nodiscard]] PredicateForm form(const PredicatePosition& place,
                                   std::span<const double> p) const override {
    return distance_form(*place.target, wanted_range(p));
  }
  [[nodiscard]] PredicateGlsl glsl(const std::string& prefix, const PredicatePosition& place,
                                   std::span<const double> p) const override {
    return distance_glsl(prefix, *place.target, wanted_range(p));
  }
};

}  // namespace

const PredicateKind& target_distance_predicate() {
  static const TargetDistance kind;
  return kind;
}

}  // namespace nav::render
