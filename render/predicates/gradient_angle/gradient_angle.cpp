// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "render/predicates/registry.hpp"

namespace nav::render {
namespace {

/// The linear form a · along + b · across. Its range over ranges of both values is exact.
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

/// Linear form of sin(angle - low) times the gradient. With it and below(), and with all angles in
/// [0, pi], both forms are >= 0 exactly for angles within [low, high]. No division and no inverse
/// cosine are needed.
Linear above(double low) { return {-std::sin(low), std::cos(low)}; }
/// Linear form of sin(high - angle) times the gradient. A high of pi means no upper limit, although
/// sin(pi) is not exactly 0 in floating point.
Linear below(double high) {
  if (high >= M_PI) return {0, 1};
  return {std::sin(high), -std::cos(high)};
}
/// Separates 0 from pi, whose across parts are both 0: a narrow range lies below or above a right
/// angle.
Linear side_of(double low, double high) {
  if (high < M_PI / 2) return {1, 0};
  if (low > M_PI / 2) return {-1, 0};
  return {0, 0};
}

/// All three forms are >= 0 for angles within [low, high].
std::array<Linear, 3> wedge_of(std::span<const double> p) {
  return {above(p[0]), below(p[1]), side_of(p[0], p[1])};
}

double slack_of(const Linear& form, const double (&quantum)[2]) {
  return wedge_slack({form.along, form.across}, quantum);
}

Range squares(const Range& r) {
  const double a = r.low * r.low;
  const double b = r.high * r.high;
  return {r.low <= 0 && r.high >= 0 ? 0 : std::min(a, b), std::max(a, b)};
}

Truth not_negative(const Range& r) {
  return r.low >= 0 ? Truth::kTrue : r.high < 0 ? Truth::kFalse : Truth::kUnknown;
}

/// Angle between the gradient and the scan line (§3.1). False if the gradient is too short to have
/// a direction, or if the scan line is unknown.
class GradientAngle final : public PredicateKind {
 public:
  [[nodiscard]] std::string name() const override { return "gradient_angle"; }
  [[nodiscard]] std::string description() const override {
    return "Angle between the gradient and the scan line, within a range; 0: brighter with depth.";
  }
  [[nodiscard]] std::vector<PredicateParameter> parameters() const override {
    return {{.name = "low_rad", .unit = "rad", .low = 0, .high = M_PI, .initial = 0},
            {.name = "high_rad", .unit = "rad", .low = 0, .high = M_PI, .initial = 0.5},
            {.name = "least_gradient_per_mm",
             .unit = "1/mm",
             .low = 1e-6,
             .high = 1e6,
             .initial = 1e-3}};
  }
  [[nodiscard]] PredicateNeeds needs(const PredicatePosition&) const override {
    PredicateNeeds needs;
    needs.channels = {feature::kGradientAlong, feature::kGradientAcross};
    needs.scan = true;
    return needs;
  }
  [[nodiscard]] Result<void> check(std::span<const double> p) const override {
    return check_order(*this, p, 0, 1);
  }
  [[nodiscard]] bool test(const PredicateSample& s, const PredicatePosition&,
                          std::span<const double> p) const override {
    const double along = s.value[0];
    const double across = s.value[1];
    if (!(along * along + across * across >= p[2] * p[2])) return false;
    const auto wedge = wedge_of(p);
    return std::all_of(wedge.begin(), wedge.end(), [&](const Linear& form) {
      return form.at(along, across) >= -slack_of(form, s.quantum);
    });
  }
  [[nodiscard]] Truth bounds(const PredicateBounds& b, const PredicatePosition&,
                             std::span<const double> p) const override {
    const Range along = squares(b.value[0]);
    const Range across = squares(b.value[1]);
    const double least = p[2] * p[2];
    const Truth steep =
        not_negative({along.low + across.low - least, along.high + across.high - least});
    Truth found = steep;
    for (const Linear& form : wedge_of(p)) {
      const Range over = form.over(b.value[0], b.value[1]);
      const double slack = slack_of(form, b.quantum);
      found = and_of(found, not_negative({over.low + slack, over.high + slack}));
    }
    return b.undefined[0] || b.undefined[1] ? and_of(found, Truth::kUnknown) : found;
  }
  [[nodiscard]] PredicateForm form(const PredicatePosition&,
                                   std::span<const double> p) const override {
    PredicateForm form;
    form.kind = PredicateForm::Kind::kWedge;
    form.low = p[2];
    const auto forms = wedge_of(p);
    for (std::size_t i = 0; i < forms.size(); ++i) {
      form.wedge[i][0] = forms[i].along;
      form.wedge[i][1] = forms[i].across;
    }
    return form;
  }
  [[nodiscard]] PredicateGlsl glsl(const std::string& prefix, const PredicatePosition&,
                                   std::span<const double> p) const override {
    const auto [a, b, side] = wedge_of(p);
    const std::string g = "vec2(VALUE0, VALUE1)";
    const std::string slack = prefix + "_slack";
    return {"uniform vec4 " + prefix + "_wedge;\nuniform vec2 " + prefix + "_side;\nuniform vec3 " +
                slack + ";\nuniform float " + prefix + "_least;\n",
            "(dot(" + g + ", " + g + ") >= " + prefix + "_least * " + prefix + "_least && dot(" +
                prefix + "_wedge.xy, " + g + ") >= -" + slack + ".x && dot(" + prefix +
                "_wedge.zw, " + g + ") >= -" + slack + ".y && dot(" + prefix + "_side, " + g +
                ") >= -" + slack + ".z)",
            {{prefix + "_wedge", {a.along, a.across, b.along, b.across}},
             {prefix + "_side", {side.along, side.across}},
             {slack, {0, 0, 0}},
             {prefix + "_least", {p[2]}}}};
  }
};

}  // namespace

const PredicateKind& gradient_angle_predicate() {
  static const GradientAngle kind;
  return kind;
}

}  // namespace nav::render
