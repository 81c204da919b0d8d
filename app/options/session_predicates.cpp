// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/session_predicates.hpp"

namespace nav::app {
namespace {

using render::features::Paint;

void read_histogram(Section& section, const std::string& file, std::optional<Error>& error,
                    PredicateOptions& options) {
  const toml::array* edits = section.tables("histogram");
  if (edits == nullptr) return;
  for (const toml::node& element : *edits) {
    Section one(file, "predicates.histogram", element.as_table(), error);
    HistogramEdit edit;
    one.required_text("entry", edit.entry);
    one.number("importance", edit.importance);
    one.number("hue_deg", edit.hue_deg);
    one.number("saturation", edit.saturation);
    one.finish();
    options.histogram.push_back(std::move(edit));
  }
}

void read_labels(Section& section, const std::string& file, PredicateOptions& options) {
  std::vector<std::string> names;
  section.texts("labels", names);
  for (const auto& name : names) {
    options.labels.push_back(std::filesystem::path(file).parent_path() / name);
  }
}

/// A preset keeps its name; anything else is a file beside the session file.
void read_set_up(Section& section, const std::string& file, PredicateOptions& options) {
  section.text("set_up", options.set_up);
  const auto beside = std::filesystem::path(file).parent_path() / options.set_up;
  if (!render::preset_predicates(options.set_up)) options.set_up = beside.string();
}

template <int Rows>
void read_vector(Section& section, const char* key,
                 std::optional<Eigen::Matrix<double, Rows, 1>>& value) {
  std::vector<double> numbers;
  section.numbers(key, Rows, numbers);
  if (!numbers.empty()) value = Eigen::Map<const Eigen::Matrix<double, Rows, 1>>(numbers.data());
}

template <class Vector>
toml::array array_of(const Vector& vector) {
  toml::array array;
  for (const double x : vector) array.push_back(x);
  return array;
}

void read_numbers(Section& section, PredicateOptions& o) {
  section.integer("phantom_side", o.phantom_side);
  section.number("scribble_share", o.scribble_share);
  section.flag("alone", o.alone);
  section.number("ct_importance", o.ct_importance);
  section.number("black", o.black);
  section.number("white", o.white);
  section.number("opacity_length_mm", o.opacity_length_mm);
  section.number("face_radius_mm", o.face_radius_mm);
  section.number("smoothing_mm", o.smoothing_mm);
  section.number("smallest_radius_mm", o.smallest_radius_mm);
  section.number("largest_radius_mm", o.largest_radius_mm);
  section.flag("bright_vessels", o.bright_vessels);
  section.whole_number("unknown", o.unknown);
  std::string hue_mean;
  section.text("hue_mean", hue_mean);
  if (!hue_mean.empty()) o.hue_mean = hue_mean;
}

toml::array histogram_to_toml(const std::vector<HistogramEdit>& edits) {
  toml::array array;
  for (const HistogramEdit& edit : edits) {
    toml::table one{{"entry", edit.entry}};
    if (edit.importance) one.insert("importance", *edit.importance);
    if (edit.hue_deg) one.insert("hue_deg", *edit.hue_deg);
    if (edit.saturation) one.insert("saturation", *edit.saturation);
    array.push_back(std::move(one));
  }
  return array;
}

}  // namespace

void read_predicates(Section& section, const std::string& file, std::optional<Error>& error,
                     PredicateOptions& o) {
  section.path("volume", o.volume);
  section.text("phantom", o.phantom);
  section.path("picture", o.picture);
  read_set_up(section, file, o);
  read_histogram(section, file, error, o);
  read_labels(section, file, o);
  section.path("layers", o.layers);
  section.path("scan_lines", o.scan_lines);
  section.path("cache", o.cache);
  section.path("scribbles", o.scribbles);
  section.path("save_set_up", o.save_set_up);
  read_numbers(section, o);
  read_vector<3>(section, "into", o.into_ct);
  read_vector<3>(section, "face_mm", o.face_ct);
  read_vector<3>(section, "apex_mm", o.apex_ct);
  read_vector<4>(section, "target_mm", o.target);
  read_vector<6>(section, "needle_mm", o.needle);
  std::optional<Eigen::Vector3d> from;
  read_vector<3>(section, "from", from);
  o.from = from.value_or(o.from);
  section.finish();
}

toml::table predicates_to_toml(const PredicateOptions& o) {
  toml::table table{
      {"phantom", o.phantom},
      {"phantom_side", o.phantom_side},
      {"set_up", render::preset_predicates(o.set_up) ? o.set_up : absolute_text(o.set_up)},
      {"scribble_share", o.scribble_share},
      {"alone", o.alone},
      {"ct_importance", o.ct_importance},
      {"black", o.black},
      {"white", o.white},
      {"face_radius_mm", o.face_radius_mm},
      {"from", array_of(o.from)}};
  for (const auto& [key, path] : {std::pair("volume", &o.volume),
                                  {"picture", &o.picture},
                                  {"layers", &o.layers},
                                  {"scan_lines", &o.scan_lines},
                                  {"cache", &o.cache},
                                  {"scribbles", &o.scribbles},
                                  {"save_set_up", &o.save_set_up}}) {
    if (!path->empty()) table.insert(key, absolute_text(*path));
  }
  if (!o.labels.empty()) {
    toml::array labels;
    for (const auto& path : o.labels) labels.push_back(absolute_text(path));
    table.insert("labels", std::move(labels));
  }
  if (!o.histogram.empty()) table.insert("histogram", histogram_to_toml(o.histogram));
  if (o.opacity_length_mm) table.insert("opacity_length_mm", *o.opacity_length_mm);
  if (o.smoothing_mm) table.insert("smoothing_mm", *o.smoothing_mm);
  if (o.smallest_radius_mm) table.insert("smallest_radius_mm", *o.smallest_radius_mm);
  if (o.largest_radius_mm) table.insert("largest_radius_mm", *o.largest_radius_mm);
  if (o.bright_vessels) table.insert("bright_vessels", *o.bright_vessels);
  if (o.hue_mean) table.insert("hue_mean", *o.hue_mean);
  if (o.unknown) table.insert("unknown", *o.unknown);
  if (o.into_ct) table.insert("into", array_of(*o.into_ct));
  if (o.face_ct) table.insert("face_mm", array_of(*o.face_ct));
  if (o.apex_ct) table.insert("apex_mm", array_of(*o.apex_ct));
  if (o.target) table.insert("target_mm", array_of(*o.target));
  if (o.needle) table.insert("needle_mm", array_of(*o.needle));
  return table;
}

}  // namespace nav::app
