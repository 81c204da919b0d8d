// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "render/predicates/registry.hpp"

namespace nav::render {
namespace {

/// The form a · along + b · across, a lower bound of which over ranges is exact.
struct Linear {
  double along;
  double across;
  [[nodiscard]] double at(double x, double y) const { return along * x + across * y; }
  [[nodiscard]] Range over(const Range& x, const Range& y) const {
    const double x_ends[2] = {along * x.low, along * x.high};
    const double y_ends[2] = {across * y.low, across * y.high};
    return {std::min(x_ends[0], x_ends[1]) + std::min(y_ends[0], y_ends[1]),
            std::max(x_ends[0], x_ends[1]) + std::max(y_ends[0], y_ends[1])};
  }
};

/// sin(angle - low) and sin(high - angle), times the gradient: with all angles in [0, pi] both are
/// >= 0 exactly within [low, high], without a division or an inverse cosine.
Linear above(double low) { return {-std::sin(low), std::cos(low)}; }
/// [.., pi] means no upper end, although sin(pi) is not quite 0 in floating point; and at high = 0
/// the least sine tells 0 from pi, both of which have no part across.
Linear below(double high) {
  constexpr double kLeastSine = 1e-12;
  if (high >= M_PI) return {0, 1};
  return {std::max(std::sin(high), kLeastSine), -std::cos(high)};
}

Range squares(const Range& r) {
  const double a = r.low * r.low;
  const double b = r.high * r.high;
  return {r.low <= 0 && r.high >= 0 ? 0 : std::min(a, b), std::max(a, b)};
}

Truth not_negative(const Range& r) {
  return r.low >= 0 ? Truth::kTrue : r.high < 0 ? Truth::kFalse : Truth::kUnknown;
}

/// Angle between the gradient and the scan line (§3.1); false where the gradient is too short to
/// have a direction, or the scan line is unknown.
class GradientAngle final : public PredicateKind {
 public:
  [[nodiscard]] std::string name() const override { return "gradient_angle"; }
  [[nodiscard]] std::string description() const override {
    return "Angle between the gradient and the scan line within a range; 0: brighter with depth.";
  }
  [[nodiscard]] std::vector<PredicateParameter> parameters() const override {
    return {{"low_rad", "rad", 0, M_PI, 0},
            {"high_rad", "rad", 0, M_PI, 0.5},
            {"least_gradient_per_mm", "1/mm", 1e-6, 1e6, 1e-3}};
  }
  [[nodiscard]] PredicateNeeds needs(const PredicatePlace&) const override {
    PredicateNeeds needs;
    needs.channels = {feature::kGradientAlong, feature::kGradientAcross};
    needs.scan = true;
    return needs;
  }
  [[nodiscard]] Result<void> check(std::span<const double> p) const override {
    return check_order(*this, p, 0, 1);
  }
  [[nodiscard]] bool test(const PredicateSample& s, const PredicatePlace&,
                          std::span<const double> p) const override {
    const double along = s.value[0];
    const double across = s.value[1];
    if (!(along * along + across * across >= p[2] * p[2])) return false;
    return above(p[0]).at(along, across) >= 0 && below(p[1]).at(along, across) >= 0;
  }
  [[nodiscard]] Truth bounds(const PredicateBounds& b, const PredicatePlace&,
                             std::span<const double> p) const override {
    const Range along = squares(b.value[0]);
    const Range across = squares(b.value[1]);
    const double least = p[2] * p[2];
    const Truth steep =
        not_negative({along.low + across.low - least, along.high + across.high - least});
    const Truth angle = and_of(not_negative(above(p[0]).over(b.value[0], b.value[1])),
                               not_negative(below(p[1]).over(b.value[0], b.value[1])));
    const Truth found = and_of(steep, angle);
    return b.undefined[0] || b.undefined[1] ? and_of(found, Truth::kUnknown) : found;
  }
  [[nodiscard]] PredicateForm form(const PredicatePlace&,
                                   std::span<const double> p) const override {
    PredicateForm form;
    form.kind = PredicateForm::Kind::kWedge;
    form.low = p[2];
    const Linear forms[2] = {above(p[0]), below(p[1])};
    for (int i = 0; i < 2; ++i) {
      form.wedge[i][0] = forms[i].along;
      form.wedge[i][1] = forms[i].across;
    }
    return form;
  }
  [[nodiscard]] PredicateGlsl glsl(const std::string& prefix, const PredicatePlace&,
                                   std::span<const double> p) const override {
    const Linear a = above(p[0]);
    const Linear b = below(p[1]);
    const std::string g = "vec2(VALUE0, VALUE1)";
    return {
        "uniform vec4 " + prefix + "_wedge;\nuniform float " + prefix + "_least;\n",
        "(dot(" + g + ", " + g + ") >= " + prefix + "_least * " + prefix + "_least && dot(" +
            prefix + "_wedge.xy, " + g + ") >= 0.0 && dot(" + prefix + "_wedge.zw, " + g +
            ") >= 0.0)",
        {{prefix + "_wedge", {a.along, a.across, b.along, b.across}}, {prefix + "_least", {p[2]}}}};
  }
};

}  // namespace

const PredicateKind& gradient_angle_predicate() {
  static const GradientAngle kind;
  return kind;
}

}  // namespace nav::render
