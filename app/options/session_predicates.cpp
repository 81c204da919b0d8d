// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/session_predicates.hpp"

#include "render/predicates/model.hpp"

namespace nav::app {

void read_histogram(Section& section, const char* key, Settings& settings) {
  const toml::array* edits = section.tables(key);
  if (edits == nullptr) return;
  for (const toml::node& element : *edits) {
    Section one = section.inside("predicates.histogram", element.as_table());
    HistogramEdit edit;
    one.required_text("entry", edit.entry);
    one.number("importance", edit.importance);
    one.number("hue_deg", edit.hue_deg);
    one.number("saturation", edit.saturation);
    one.number("floor", edit.floor);
    one.finish();
    settings.config.predicates.histogram.push_back(std::move(edit));
  }
}

void write_histogram(KeyWriter& writer, const char* key, const Settings& settings) {
  toml::array edits;
  for (const HistogramEdit& edit : settings.config.predicates.histogram) {
    toml::table one{{"entry", edit.entry}};
    if (edit.importance) one.insert("importance", *edit.importance);
    if (edit.hue_deg) one.insert("hue_deg", *edit.hue_deg);
    if (edit.saturation) one.insert("saturation", *edit.saturation);
    if (edit.floor) one.insert("floor", *edit.floor);
    edits.push_back(std::move(one));
  }
  if (!edits.empty()) writer.table.insert(key, std::move(edits));
}

void read_predicate_set(Section& section, const char* key, Settings& settings) {
  std::string& set = settings.config.predicates.set_up;
  section.text(key, set);
  if (!render::preset_predicates(set)) set = section.beside_file(set).string();
}

void write_predicate_set(KeyWriter& writer, const char* key, const Settings& settings) {
  const std::string& set = settings.config.predicates.set_up;
  writer.table.insert(key, render::preset_predicates(set) ? set : writer.path(set));
}

}  // namespace nav::app
