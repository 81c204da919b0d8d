// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "render/transfer/transfer_presets.hpp"

namespace nav::render {
namespace {

using Histogram = std::vector<std::uint64_t>;
constexpr int kLeastHu = std::numeric_limits<std::int16_t>::min();

/// The border between the two classes that differ most (Otsu 1979), as a bin.
std::size_t otsu_bin(const Histogram& histogram, double total) {
  double sum = 0;
  for (std::size_t i = 0; i < histogram.size(); ++i) {
    sum += static_cast<double>(i) * static_cast<double>(histogram[i]);
  }
  double below = 0;
  double sum_below = 0;
  double best = -1;
  std::size_t border = 0;
  for (std::size_t i = 0; i + 1 < histogram.size(); ++i) {
    below += static_cast<double>(histogram[i]);
    sum_below += static_cast<double>(i) * static_cast<double>(histogram[i]);
    if (!(below > 0) || !(below < total)) continue;
    const double apart = sum_below / below - (sum - sum_below) / (total - below);
    const double score = below * (total - below) * apart * apart;
    if (score > best) {
      best = score;
      border = i;
    }
  }
  return border;
}

/// A component's node at a value, by the component's definition: linear in extinction.
TransferNode node_at(const std::vector<TransferNode>& nodes, double hu) {
  const auto above =
      std::find_if(nodes.begin(), nodes.end(), [hu](const TransferNode& n) { return n.hu > hu; });
  TransferNode node = above == nodes.begin() ? nodes.front() : *(above - 1);
  if (above != nodes.begin() && above != nodes.end()) {
    const double w = (hu - node.hu) / (above->hu - node.hu);
    const double tau = std::log1p(-node.opacity) * (1 - w) + std::log1p(-above->opacity) * w;
    node.rgb += w * (above->rgb - node.rgb);
    node.opacity = -std::expm1(tau);
    node.importance += w * (above->importance - node.importance);
  }
  node.hu = hu;
  return node;
}

void add_node(std::vector<TransferNode>& nodes, double hu) {
  if (!std::isfinite(hu)) return;
  const TransferNode node = node_at(nodes, hu);
  const auto at = std::lower_bound(nodes.begin(), nodes.end(), hu,
                                   [](const TransferNode& n, double x) { return n.hu < x; });
  if (at == nodes.end() || at->hu != hu) nodes.insert(at, node);
}

void apply(const ImportanceRule& rule, std::vector<TransferNode>& nodes) {
  constexpr double kJumpHu = 0.5;
  for (const double hu :
       {rule.low_hu - kJumpHu, rule.low_hu, rule.high_hu, rule.high_hu + kJumpHu}) {
    add_node(nodes, hu);
  }
  for (TransferNode& node : nodes) {
    if (node.hu >= rule.low_hu && node.hu <= rule.high_hu) node.importance = rule.importance;
  }
}

Result<void> check(const TransferFunction& function, const ImportanceRule& rule) {
  const auto reject = [&](const std::string& expected, auto found) {
    std::ostringstream text;
    text << "importance of " << rule.low_hu << " to " << rule.high_hu << ": expected " << expected
         << ", found " << found;
    return Error{ErrorCode::kUsage, text.str()};
  };
  if (!(rule.low_hu <= rule.high_hu))
    return reject("a range that does not end below its begin", rule.high_hu);
  if (!(rule.importance >= 0 && rule.importance <= 1)) {
    return reject("an importance in [0, 1]", rule.importance);
  }
  if (rule.component.empty()) return {};
  std::string known;
  for (const TransferComponent& component : function.components()) {
    if (component.name == rule.component) return {};
    known += (known.empty() ? "" : ", ") + component.name;
  }
  return reject("one of the components " + known, rule.component);
}

double scale_of(const ValueRange& from, const ValueRange& to) {
  NAV_CHECK(from.high > from.low && to.high > to.low, from.low, from.high, to.low, to.high);
  return (to.high - to.low) / (from.high - from.low);
}

}  // namespace

ValueRange value_range(const StoredVolume& volume) {
  Histogram histogram(65536, 0);
  for (const std::int16_t value : volume.values())
    ++histogram[static_cast<std::size_t>(value - kLeastHu)];
  const std::size_t border = otsu_bin(histogram, static_cast<double>(volume.values().size()));
  double above = 0;
  for (std::size_t i = border + 1; i < histogram.size(); ++i) {
    above += static_cast<double>(histogram[i]);
  }
  constexpr double kKept = 0.995;
  double seen = 0;
  std::size_t last = border + 1;
  for (std::size_t i = border + 1; i < histogram.size() && seen < kKept * above; ++i) {
    seen += static_cast<double>(histogram[i]);
    last = i;
  }
  // Not the border: it may lie between muscle and fat.
  constexpr double kDark = 0.01;
  const double dark = kDark * static_cast<double>(volume.values().size());
  std::size_t first = 0;
  for (double below = static_cast<double>(histogram[0]); below < dark && first < border;) {
    below += static_cast<double>(histogram[++first]);
  }
  // A volume of a single value has no background; it still gets a range.
  const double low = static_cast<double>(first) + kLeastHu;
  return {low, std::max(static_cast<double>(last) + kLeastHu, low + 1)};
}

Result<TransferFunction> rescaled(const TransferFunction& function, const ValueRange& from,
                                  const ValueRange& to) {
  const double factor = scale_of(from, to);
  std::vector<TransferComponent> components = function.components();
  for (TransferComponent& component : components) {
    for (TransferNode& node : component.nodes) node.hu = to.low + factor * (node.hu - from.low);
    if (!component.gradient) continue;
    GradientWindow& w = *component.gradient;
    for (double* edge : {&w.zero_below, &w.full_from, &w.full_to, &w.zero_above}) *edge *= factor;
  }
  return TransferFunction::blend(function.name(), std::move(components));
}

Shading rescaled(Shading shading, const ValueRange& from, const ValueRange& to) {
  shading.full_gradient_per_mm *= scale_of(from, to);
  return shading;
}

Result<TransferFunction> with_importance(const TransferFunction& function,
                                         const std::vector<ImportanceRule>& rules) {
  std::vector<TransferComponent> components = function.components();
  for (const ImportanceRule& rule : rules) {
    if (const auto ok = check(function, rule); !ok) return ok.error();
    for (TransferComponent& component : components) {
      if (rule.component.empty() || rule.component == component.name) apply(rule, component.nodes);
    }
  }
  return TransferFunction::blend(function.name(), std::move(components));
}

}  // namespace nav::render
