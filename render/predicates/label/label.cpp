// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>

#include "render/predicates/registry.hpp"

namespace nav::render {
namespace {

std::uint32_t mask_of(std::span<const double> p) { return static_cast<std::uint32_t>(p[0]); }

/// True for at least one of the labels of a mask (§3.1, second version: a voxel grid of bit masks).
class Label final : public PredicateKind {
 public:
  [[nodiscard]] std::string name() const override { return "label"; }
  [[nodiscard]] std::string description() const override {
    return "The nearest voxel is labelled with at least one bit of a mask.";
  }
  [[nodiscard]] std::vector<PredicateParameter> parameters() const override {
    return {{.name = "mask", .unit = "1", .low = 1, .high = 4294967295.0, .initial = 1}};
  }
  [[nodiscard]] PredicateNeeds needs(const PredicatePosition&) const override {
    PredicateNeeds needs;
    needs.labels = true;
    return needs;
  }
  [[nodiscard]] Result<void> check(std::span<const double> p) const override {
    if (p[0] == std::floor(p[0])) return {};
    return Error{ErrorCode::kMalformedData,
                 "label: expected a whole number as mask, found " + std::to_string(p[0])};
  }
  [[nodiscard]] bool test(const PredicateSample& s, const PredicatePosition&,
                          std::span<const double> p) const override {
    return (s.labels & mask_of(p)) != 0;
  }
  [[nodiscard]] Truth bounds(const PredicateBounds& b, const PredicatePosition&,
                             std::span<const double> p) const override {
    if ((b.labels_all & mask_of(p)) != 0) return Truth::kTrue;
    return (b.labels_any & mask_of(p)) == 0 ? Truth::kFalse : Truth::kUnknown;
  }
  [[nodiscard]] PredicateForm form(const PredicatePosition&,
                                   std::span<const double> p) const override {
    PredicateForm form;
    form.kind = PredicateForm::Kind::kBits;
    form.mask = mask_of(p);
    return form;
  }
  [[nodiscard]] PredicateGlsl glsl(const std::string& prefix, const PredicatePosition&,
                                   std::span<const double> p) const override {
    return {"uniform uint " + prefix + "_mask;\n",
            "((LABELS & " + prefix + "_mask) != 0u)",
            {},
            mask_of(p)};
  }
};

}  // namespace

const PredicateKind& label_predicate() {
  static const Label kind;
  return kind;
}

}  // namespace nav::render
