// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/session_look.hpp"

namespace nav::app {
namespace {

void read_nodes(Section& section, const std::string& file, std::optional<Error>& error,
                SessionConfig::Look& look) {
  const toml::array* nodes = section.tables("nodes");
  if (nodes == nullptr) return;
  for (const toml::node& element : *nodes) {
    Section one(file, "look.nodes", element.as_table(), error);
    render::TransferNode node{0, {1, 1, 1}, 0, 0.5};
    std::vector<double> rgb = {1, 1, 1};
    one.required_number("hu", node.hu);
    one.numbers("rgb", 3, rgb);
    one.required_number("opacity_per_mm", node.opacity);
    one.number("importance", node.importance);
    one.finish();
    node.rgb = {rgb[0], rgb[1], rgb[2]};
    look.nodes.push_back(node);
  }
}

void read_importance(Section& section, const std::string& file, std::optional<Error>& error,
                     SessionConfig::Look& look) {
  const toml::array* rules = section.tables("importance");
  if (rules == nullptr) return;
  for (const toml::node& element : *rules) {
    Section one(file, "look.importance", element.as_table(), error);
    render::ImportanceRule rule{-1e6, 1e6, 0.5};
    one.number("low_hu", rule.low_hu);
    one.number("high_hu", rule.high_hu);
    one.required_number("importance", rule.importance);
    one.text("component", rule.component);
    one.finish();
    look.importance.push_back(std::move(rule));
  }
}

void read_cutaway(Section& section, const std::string& file, std::optional<Error>& error,
                  SessionConfig::Look::Cutaway& cutaway) {
  const toml::table* table = section.table("cutaway");
  Section one(file, "look.cutaway", table, error);
  one.flag("enabled", cutaway.enabled);
  one.number("theta1_deg", cutaway.theta1_deg);
  one.number("theta2_deg", cutaway.theta2_deg);
  one.number_or_infinity("overlay_mm", cutaway.overlay_mm);
  one.flag("around_plane", cutaway.around_plane);
  one.flag("around_needle", cutaway.around_needle);
  one.flag("around_targets", cutaway.around_targets);
  one.finish();
}

template <class Value>
void insert_if(toml::table& table, const char* key, const std::optional<Value>& value) {
  if (value) table.insert(key, *value);
}

toml::table cutaway_to_toml(const SessionConfig::Look::Cutaway& cutaway) {
  toml::table table;
  insert_if(table, "enabled", cutaway.enabled);
  insert_if(table, "theta1_deg", cutaway.theta1_deg);
  insert_if(table, "theta2_deg", cutaway.theta2_deg);
  insert_if(table, "overlay_mm", cutaway.overlay_mm);
  insert_if(table, "around_plane", cutaway.around_plane);
  insert_if(table, "around_needle", cutaway.around_needle);
  insert_if(table, "around_targets", cutaway.around_targets);
  return table;
}

}  // namespace

void read_look(Section& section, const std::string& file, std::optional<Error>& error,
               SessionConfig::Look& look) {
  section.text("transfer_function", look.preset);
  section.path("file", look.file);
  section.path("save", look.save);
  section.flag("shading", look.shading);
  std::string style;
  section.text("style", style);
  if (!style.empty()) look.style = style;
  section.number("emphasis", look.emphasis);
  section.number("plane_opacity", look.plane_opacity);
  section.text("projection", look.projection);
  section.number("grey_level_hu", look.grey_level_hu);
  section.number("grey_width_hu", look.grey_width_hu);
  read_nodes(section, file, error, look);
  read_importance(section, file, error, look);
  read_cutaway(section, file, error, look.cutaway);
  section.finish();
}

Result<void> validate(const SessionConfig::Look& look) {
  const auto refuse = [](const std::string& key, const std::string& expected, auto found) {
    std::ostringstream text;
    text << "look." << key << ": expected " << expected << ", found " << found;
    return Error{ErrorCode::kUsage, text.str()};
  };
  const auto within = [](double value, double low, double high) {
    return value >= low && value <= high;
  };
  if (!within(look.plane_opacity, 0.01, 1)) {
    return refuse("plane_opacity", "0.01 to 1", look.plane_opacity);
  }
  if (look.style && *look.style != "phong" && *look.style != "gooch") {
    return refuse("style", "phong or gooch", *look.style);
  }
  if (!within(look.emphasis.value_or(0), 0, 1)) return refuse("emphasis", "0 to 1", *look.emphasis);
  const std::set<std::string> projections{"composite", "maximum", "minimum", "mean"};
  if (!projections.contains(look.projection)) {
    return refuse("projection", "composite, maximum, minimum or mean", look.projection);
  }
  if (!within(look.grey_level_hu.value_or(0), -1e6, 1e6)) {
    return refuse("grey_level_hu", "-10^6 to 10^6", *look.grey_level_hu);
  }
  const double grey_width_hu = look.grey_width_hu.value_or(1);
  if (!(grey_width_hu > 0 && grey_width_hu <= 1e6)) {
    return refuse("grey_width_hu", "more than 0 to 10^6", grey_width_hu);
  }
  const auto& cutaway = look.cutaway;
  for (const auto& [key, angle] : {std::pair("cutaway.theta1_deg", cutaway.theta1_deg),
                                   {"cutaway.theta2_deg", cutaway.theta2_deg}}) {
    if (!within(angle.value_or(45), 0.1, 89.9)) return refuse(key, "0.1 to 89.9", *angle);
  }
  if (cutaway.theta1_deg && cutaway.theta2_deg && *cutaway.theta1_deg > *cutaway.theta2_deg) {
    return refuse("cutaway.theta1_deg", "at most theta2_deg", *cutaway.theta1_deg);
  }
  if (!(cutaway.overlay_mm.value_or(0) >= 0)) {
    return refuse("cutaway.overlay_mm", "0 or more, or inf", *cutaway.overlay_mm);
  }
  return {};
}

toml::table look_to_toml(const SessionConfig::Look& look) {
  toml::table table{{"transfer_function", look.preset},
                    {"shading", look.shading},
                    {"plane_opacity", look.plane_opacity},
                    {"projection", look.projection}};
  insert_if(table, "grey_level_hu", look.grey_level_hu);
  insert_if(table, "grey_width_hu", look.grey_width_hu);
  if (!look.file.empty()) {
    table.insert("file", std::filesystem::absolute(look.file).lexically_normal().string());
  }
  if (!look.save.empty()) table.insert("save", absolute_text(look.save));
  insert_if(table, "style", look.style);
  insert_if(table, "emphasis", look.emphasis);
  toml::array nodes;
  for (const render::TransferNode& node : look.nodes) {
    nodes.push_back(toml::table{{"hu", node.hu},
                                {"rgb", toml::array{node.rgb[0], node.rgb[1], node.rgb[2]}},
                                {"opacity_per_mm", node.opacity},
                                {"importance", node.importance}});
  }
  if (!nodes.empty()) table.insert("nodes", std::move(nodes));
  toml::array rules;
  for (const render::ImportanceRule& rule : look.importance) {
    rules.push_back(toml::table{{"low_hu", rule.low_hu},
                                {"high_hu", rule.high_hu},
                                {"importance", rule.importance},
                                {"component", rule.component}});
  }
  if (!rules.empty()) table.insert("importance", std::move(rules));
  toml::table cutaway = cutaway_to_toml(look.cutaway);
  if (!cutaway.empty()) table.insert("cutaway", std::move(cutaway));
  return table;
}

}  // namespace nav::app
