// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/transfer_function.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace nav::render {
namespace {

bool in_unit(double x) { return x >= 0 && x <= 1; }  // false for NaN.

double tau_of(const TransferNode& node) { return -std::log1p(-node.opacity); }

Result<void> check_node(const std::string& name, const std::vector<TransferNode>& nodes,
                        std::size_t i) {
  const TransferNode& node = nodes[i];
  const auto reject = [&](const std::string& expected, auto found) {
    std::ostringstream text;
    text << "transfer function " << name << ": node " << i << ": expected " << expected
         << ", found " << found;
    return Error{ErrorCode::kMalformedData, text.str()};
  };
  if (!std::isfinite(node.hu)) return reject("a finite value in HU", node.hu);
  if (i > 0 && !(node.hu > nodes[i - 1].hu)) {
    std::ostringstream expected;
    expected << "more than the " << nodes[i - 1].hu << " HU of the previous node";
    return reject(expected.str(), node.hu);
  }
  for (int c = 0; c < 3; ++c) {
    if (!in_unit(node.rgb[c])) return reject("colours in [0, 1]", node.rgb[c]);
  }
  if (!(node.opacity >= 0 && node.opacity < 1)) {
    return reject("an opacity of 1 mm in [0, 1)", node.opacity);
  }
  if (!in_unit(node.importance)) return reject("an importance in [0, 1]", node.importance);
  return {};
}

double in_component_weight(const GradientWindow& w, double g) {
  if (g >= w.full_from && g <= w.full_to) return 1;
  if (g <= w.zero_below || g >= w.zero_above) return 0;
  return g < w.full_from ? (g - w.zero_below) / (w.full_from - w.zero_below)
                         : (w.zero_above - g) / (w.zero_above - w.full_to);
}

/// Samples one component, without its gradient window. taus: extinction of its nodes.
TransferSample at_nodes(const std::vector<TransferNode>& nodes, const std::vector<double>& taus,
                        double hu) {
  const auto above = std::upper_bound(nodes.begin(), nodes.end(), hu,
                                      [](double x, const TransferNode& n) { return x < n.hu; });
  const auto next = static_cast<std::size_t>(above - nodes.begin());
  if (next == 0 || next == nodes.size()) {
    const std::size_t end = next == 0 ? 0 : next - 1;
    return {nodes[end].rgb, taus[end], nodes[end].importance};
  }
  const TransferNode& a = nodes[next - 1];
  const TransferNode& b = nodes[next];
  const double w = (hu - a.hu) / (b.hu - a.hu);
  return {a.rgb + w * (b.rgb - a.rgb), taus[next - 1] + w * (taus[next] - taus[next - 1]),
          a.importance + w * (b.importance - a.importance)};
}

/// Distance from a value to the nearest value at which a component may be visible, HU; infinity if
/// it is nowhere visible.
double distance_to_visible(const std::vector<TransferNode>& nodes, double hu) {
  const auto past = [hu](double low, double high) { return std::max({low - hu, hu - high, 0.0}); };
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double best = kInfinity;
  if (nodes.front().opacity > 0) best = past(-kInfinity, nodes.front().hu);
  if (nodes.back().opacity > 0) best = std::min(best, past(nodes.back().hu, kInfinity));
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    if (!(nodes[i - 1].opacity > 0 || nodes[i].opacity > 0)) continue;
    best = std::min(best, past(nodes[i - 1].hu, nodes[i].hu));
  }
  return best;
}

Result<void> check_window(const std::string& name, const GradientWindow& w) {
  if (w.zero_below >= 0 && w.zero_below <= w.full_from && w.full_from <= w.full_to &&
      w.full_to <= w.zero_above && std::isfinite(w.full_from) &&
      std::isfinite(w.full_to) == std::isfinite(w.zero_above)) {
    return {};
  }
  std::ostringstream text;
  text << "transfer function " << name
       << ": gradient window: expected 0 <= zero_below <= full_from <= full_to <= zero_above in "
          "HU/mm, the last two finite or both infinite, found "
       << w.zero_below << ", " << w.full_from << ", " << w.full_to << ", " << w.zero_above;
  return Error{ErrorCode::kMalformedData, text.str()};
}

bool same_window(const std::optional<GradientWindow>& a, const std::optional<GradientWindow>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->zero_below == b->zero_below && a->full_from == b->full_from &&
         a->full_to == b->full_to && a->zero_above == b->zero_above;
}

}  // namespace

TransferFunction::TransferFunction(std::string name, std::vector<TransferComponent> components)
    : name_(std::move(name)), components_(std::move(components)) {
  for (const TransferComponent& component : components_) {
    std::vector<double>& taus = taus_per_mm_.emplace_back();
    for (const TransferNode& node : component.nodes) {
      values_.push_back(node.hu);
      taus.push_back(tau_of(node));
    }
  }
  std::sort(values_.begin(), values_.end());
  values_.erase(std::unique(values_.begin(), values_.end()), values_.end());
}

Result<TransferFunction> TransferFunction::create(std::string name,
                                                  std::vector<TransferNode> nodes) {
  return blend(name, {{name, std::move(nodes), {}}});
}

Result<TransferFunction> TransferFunction::blend(std::string name,
                                                 std::vector<TransferComponent> components) {
  if (components.empty()) {
    return Error{ErrorCode::kMalformedData,
                 "transfer function " + name + ": expected at least one component, found none"};
  }
  for (const TransferComponent& component : components) {
    const std::string where =
        components.size() == 1 ? name : name + ": component " + component.name;
    if (component.nodes.size() < 2) {
      return Error{ErrorCode::kMalformedData, "transfer function " + where +
                                                  ": expected at least two nodes, found " +
                                                  std::to_string(component.nodes.size())};
    }
    for (std::size_t i = 0; i < component.nodes.size(); ++i) {
      if (const auto ok = check_node(where, component.nodes, i); !ok) return ok.error();
    }
    if (!component.gradient) continue;
    if (const auto ok = check_window(where, *component.gradient); !ok) return ok.error();
  }
  return TransferFunction(std::move(name), std::move(components));
}

TransferSample TransferFunction::at(double hu, double gradient_hu_per_mm) const {
  Eigen::Vector3d by_importance = Eigen::Vector3d::Zero();
  Eigen::Vector3d by_opacity = Eigen::Vector3d::Zero();
  double importance_weight = 0;
  double opacity_weight = 0;
  TransferSample best{Eigen::Vector3d::Zero(), 0, 0};
  for (std::size_t i = 0; i < components_.size(); ++i) {
    const TransferComponent& component = components_[i];
    TransferSample sample = at_nodes(component.nodes, taus_per_mm_[i], hu);
    if (component.gradient)
      sample.tau_per_mm *= in_component_weight(*component.gradient, gradient_hu_per_mm);
    if (!(sample.tau_per_mm > 0)) continue;
    if (sample.importance >= kFullImportance) sample.importance = 1;
    const double opacity = -std::expm1(-sample.tau_per_mm);
    by_importance += opacity * sample.importance * sample.rgb;
    importance_weight += opacity * sample.importance;
    by_opacity += opacity * sample.rgb;
    opacity_weight += opacity;
    best.tau_per_mm = std::max(best.tau_per_mm, sample.tau_per_mm);
    best.importance = std::max(best.importance, sample.importance);
  }
  if (importance_weight > 0) {
    best.rgb = by_importance / importance_weight;
  } else if (opacity_weight > 0) {
    best.rgb = by_opacity / opacity_weight;
  } else {
    best.rgb = invisible_colour(hu);
  }
  best.rgb = best.rgb.cwiseMax(0).cwiseMin(1);  // Quotients may round beyond 1.
  return best;
}

Eigen::Vector3d TransferFunction::invisible_colour(double hu) const {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < components_.size(); ++i) {
    const double distance = distance_to_visible(components_[i].nodes, hu);
    if (distance < least) {
      least = distance;
      nearest = i;
    }
  }
  return at_nodes(components_[nearest].nodes, taus_per_mm_[nearest], hu).rgb;
}

bool TransferFunction::uses_gradient() const {
  return std::any_of(components_.begin(), components_.end(),
                     [](const TransferComponent& c) { return c.gradient.has_value(); });
}

bool operator==(const TransferNode& a, const TransferNode& b) {
  return a.hu == b.hu && a.rgb == b.rgb && a.opacity == b.opacity && a.importance == b.importance;
}

bool same_classification(const TransferFunction& a, const TransferFunction& b) {
  return std::equal(a.components().begin(), a.components().end(), b.components().begin(),
                    b.components().end(),
                    [](const TransferComponent& x, const TransferComponent& y) {
                      return x.nodes == y.nodes && same_window(x.gradient, y.gradient);
                    });
}

}  // namespace nav::render
