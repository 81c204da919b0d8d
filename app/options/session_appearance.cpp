// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/session_appearance.hpp"

namespace nav::app {

void read_appearance_nodes(Section& section, const char* key, Settings& settings) {
  const toml::array* nodes = section.tables(key);
  if (nodes == nullptr) return;
  for (const toml::node& element : *nodes) {
    Section one = section.inside("look.nodes", element.as_table());
    render::TransferNode node{0, {1, 1, 1}, 0, 0.5};
    std::vector<double> rgb = {1, 1, 1};
    one.required_number("hu", node.hu);
    one.numbers("rgb", 3, rgb);
    one.required_number("opacity_per_mm", node.opacity);
    one.number("importance", node.importance);
    one.finish();
    node.rgb = {rgb[0], rgb[1], rgb[2]};
    settings.config.appearance.nodes.push_back(node);
  }
}

void write_appearance_nodes(KeyWriter& writer, const char* key, const Settings& settings) {
  toml::array nodes;
  for (const render::TransferNode& node : settings.config.appearance.nodes) {
    nodes.push_back(toml::table{{"hu", node.hu},
                                {"rgb", toml::array{node.rgb[0], node.rgb[1], node.rgb[2]}},
                                {"opacity_per_mm", node.opacity},
                                {"importance", node.importance}});
  }
  if (!nodes.empty()) writer.table.insert(key, std::move(nodes));
}

void read_appearance_importance(Section& section, const char* key, Settings& settings) {
  const toml::array* rules = section.tables(key);
  if (rules == nullptr) return;
  for (const toml::node& element : *rules) {
    Section one = section.inside("look.importance", element.as_table());
    render::ImportanceRule rule{-1e6, 1e6, 0.5};
    one.number("low_hu", rule.low_hu);
    one.number("high_hu", rule.high_hu);
    one.required_number("importance", rule.importance);
    one.text("component", rule.component);
    one.finish();
    settings.config.appearance.importance.push_back(std::move(rule));
  }
}

void write_appearance_importance(KeyWriter& writer, const char* key, const Settings& settings) {
  toml::array rules;
  for (const render::ImportanceRule& rule : settings.config.appearance.importance) {
    rules.push_back(toml::table{{"low_hu", rule.low_hu},
                                {"high_hu", rule.high_hu},
                                {"importance", rule.importance},
                                {"component", rule.component}});
  }
  if (!rules.empty()) writer.table.insert(key, std::move(rules));
}

}  // namespace nav::app
