// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicate_legend.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "render/spec/predicate_spec.hpp"

namespace nav::app {

Rgba8 bar_colour(const render::PredicateHistogram::Bar& bar) {
  const auto rgb = render::spec::hsl(render::spec::hsl_tint(bar.hue_deg, bar.saturation), 0.5);
  const auto byte = [](double x) { return static_cast<std::uint8_t>(std::lround(255 * x)); };
  return {byte(rgb.x()), byte(rgb.y()), byte(rgb.z()), 255};
}

std::string LegendEntry::importance_words() const {
  char words[16];
  std::snprintf(words, sizeof words, "%.3f", importance);
  return words;
}

std::vector<LegendEntry> legend_of(const render::PredicateModel& model) {
  std::vector<LegendEntry> legend;
  for (std::size_t i = 0; i < model.entries.size(); ++i) {
    const auto& bar = model.histogram.bars()[i];
    legend.push_back({bar_colour(bar), model.entries[i].name, bar.importance});
  }
  return legend;
}

std::vector<LegendEntry> legend_of(const render::TransferFunction& transfer) {
  std::vector<LegendEntry> legend;
  for (const render::TransferComponent& component : transfer.components()) {
    if (component.name.empty()) continue;
    const auto node = std::ranges::max_element(component.nodes, {}, &render::TransferNode::opacity);
    const auto byte = [](double x) { return static_cast<std::uint8_t>(std::lround(255 * x)); };
    legend.push_back({{byte(node->rgb.x()), byte(node->rgb.y()), byte(node->rgb.z()), 255},
                      component.name,
                      node->importance});
  }
  return legend;
}

}  // namespace nav::app
