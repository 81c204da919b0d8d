// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Keys of the session file that hold the state of the window. No option sets them.
#include <algorithm>
#include <iterator>

#include "app/appearance/appearance_file.hpp"
#include "app/options/option_rows.hpp"
#include "app/options/session_section.hpp"
#include "app/predicates/predicate_file.hpp"
#include "app/predicates/predicate_scribbles.hpp"

namespace nav::app {
namespace {

constexpr double kFarthestMm = 1e6;

const std::vector<std::string> kViews{"view3d",   "ultrasound", "ctplane", "axial",   "coronal",
                                      "sagittal", "needle1",    "needle2", "bullseye"};

const std::vector<std::string> kSecondViews{"view3d", "ultrasound", "ctplane", "slices"};

void read_second_views(Section& section, const char* key, Settings& settings) {
  std::vector<std::string> found;
  section.texts(key, found);
  auto& views = settings.config.window.second_views;
  for (const std::string& view : found) {
    if (std::ranges::count(kSecondViews, view) == 0 || std::ranges::count(found, view) > 1) {
      return section.reject(key, "each of view3d, ultrasound, ctplane, slices at most once", view);
    }
  }
  std::ranges::copy_if(kSecondViews, std::back_inserter(views), [&](const std::string& view) {
    return std::ranges::count(found, view) > 0;
  });
}

void write_second_views(KeyWriter& writer, const char* key, const Settings& settings) {
  toml::array list;
  for (const std::string& view : settings.config.window.second_views) list.push_back(view);
  if (!list.empty()) writer.table.insert(key, std::move(list));
}

/// Reads a text that another format describes, and names the line of one that does not fit.
template <class Parse>
void read_embedded(Section& section, const char* key, std::optional<std::string>& text,
                   Parse parse) {
  std::string found;
  section.text(key, found);
  if (found.empty()) return;
  if (const auto parsed = parse(std::string("the text"), found); !parsed) {
    return section.reject(key, "text of its own format", parsed.error().message);
  }
  text = std::move(found);
}

void read_zooms(Section& section, const char* key, Settings& settings) {
  const toml::array* list = section.tables(key);
  if (list == nullptr) return;
  auto& zooms = settings.config.window.zooms;
  for (const toml::node& element : *list) {
    const std::string name = "window.zooms[" + std::to_string(zooms.size()) + "]";
    Section one = section.inside(name, element.as_table());
    WindowState::Zoom zoom;
    std::vector<double> shift{0, 0};
    one.required_text("view", zoom.view);
    one.number("factor", zoom.factor);
    one.numbers("shift_mm", 2, shift);
    one.finish();
    if (std::ranges::count(kViews, zoom.view) == 0) {
      return section.stop_at(
          element, name + ".view: expected the name of a view, found '" + zoom.view + "'");
    }
    if (!(zoom.factor >= 0.25 && zoom.factor <= 64)) {
      return section.stop_at(
          element, name + ".factor: expected 0.25 to 64, found " + std::to_string(zoom.factor));
    }
    zoom.shift_mm = Eigen::Map<const Eigen::Vector2d>(shift.data());
    if (!(zoom.shift_mm.cwiseAbs().maxCoeff() <= 2000)) {
      return section.stop_at(element, name + ".shift_mm: expected numbers within 2000 mm, found " +
                                          std::to_string(zoom.shift_mm.cwiseAbs().maxCoeff()));
    }
    zooms.push_back(zoom);
  }
}

void write_zooms(KeyWriter& writer, const char* key, const Settings& settings) {
  toml::array list;
  for (const auto& zoom : settings.config.window.zooms) {
    list.push_back(toml::table{{"view", zoom.view},
                               {"factor", zoom.factor},
                               {"shift_mm", toml::array{zoom.shift_mm.x(), zoom.shift_mm.y()}}});
  }
  if (!list.empty()) writer.table.insert(key, std::move(list));
}

void write_text(KeyWriter& writer, const char* key, const std::optional<std::string>& text) {
  if (text) writer.table.insert(key, *text);
}

Option choice(const char* key, const char* text, Slot (*slot)(Settings&),
              std::vector<std::string> choices) {
  return {.type = "NAME",
          .text = text,
          .group = group::kGroupWindowState,
          .slot = slot,
          .choices = std::move(choices),
          .absent = "none",
          .key = key};
}

Option value(const char* key, const char* text, const char* unit, Slot (*slot)(Settings&),
             Range range) {
  return {.type = std::string_view(unit) == "mm" ? "MM" : "X",
          .unit = unit,
          .text = text,
          .group = group::kGroupWindowState,
          .slot = slot,
          .range = range,
          .absent = "none",
          .key = key};
}

Option key_of(const char* key, const char* text, const char* unit, Slot (*slot)(Settings&)) {
  return {.type = "TEXT",
          .unit = unit,
          .text = text,
          .group = group::kGroupWindowState,
          .slot = slot,
          .absent = "none",
          .key = key};
}

Option embedded(const char* key, const char* text, void (*read)(Section&, const char*, Settings&),
                void (*write)(KeyWriter&, const char*, const Settings&)) {
  Option made = key_of(key, text, "", nullptr);
  made.read = read;
  made.write = write;
  return made;
}

}  // namespace

void add_window_state_rows(std::vector<Option>& rows) {
  const std::vector<std::string> layouts{"guidance", "slices", "needle", "single"};
  const Range everywhere = within(-kFarthestMm, kFarthestMm);
  const std::vector<Option> state{
      choice("window.layout", "layout of the views", NAV_SLOT(config.window.layout), layouts),
      choice("window.layout_before", "layout to which a view that is alone goes back",
             NAV_SLOT(config.window.layout_before), {"guidance", "slices", "needle"}),
      choice("window.single", "view that is alone", NAV_SLOT(config.window.single), kViews),
      value("window.step", "chosen step", "", NAV_SLOT(config.window.step), within(1, 7)),
      choice("window.panel", "open panel", NAV_SLOT(config.window.panel),
             {"step", "predicates", "transfer", "cutaway"}),
      choice("window.verdict", "the user's word about the registration in use",
             NAV_SLOT(config.window.verdict), {"accepted", "rejected"}),
      key_of("window.cursor_mm", "cursor of the slices, LPS", "mm",
             NAV_SLOT(config.window.cursor_mm)),
      value("window.grey_level", "middle of the grey window of the CT's slices", "HU",
            NAV_SLOT(config.window.grey_level), everywhere),
      value("window.grey_width", "extent of the grey window of the CT's slices", "HU",
            NAV_SLOT(config.window.grey_width), within(0.001, 1e6)),
      value("window.ultrasound_level", "middle of the grey window of slices of 3D ultrasound",
            "stored values", NAV_SLOT(config.window.ultrasound_level), everywhere),
      value("window.ultrasound_width", "extent of the grey window of slices of 3D ultrasound",
            "stored values", NAV_SLOT(config.window.ultrasound_width), within(0.001, 1e6)),
      {.type = "LIST",
       .text = "views of the second screen: view3d, ultrasound, ctplane, slices",
       .group = group::kGroupWindowState,
       .absent = "those of the window",
       .key = "window.second_views",
       .read = read_second_views,
       .write = write_second_views},
      {.type = "LIST",
       .text = "zooms and shifts of slices, a list of tables: view, factor, shift_mm",
       .group = group::kGroupWindowState,
       .absent = "none",
       .key = "window.zooms",
       .read = read_zooms,
       .write = write_zooms},
      key_of("window.camera.eye_mm", "eye of the 3D view, LPS", "mm",
             NAV_SLOT(config.window.camera.eye_mm)),
      key_of("window.camera.look_at_mm", "point that the 3D view looks at, LPS", "mm",
             NAV_SLOT(config.window.camera.look_at_mm)),
      key_of("window.camera.up", "direction that is up in the 3D view, LPS", "",
             NAV_SLOT(config.window.camera.up)),
      value("window.camera.fov_deg", "field of view of the 3D view from top to bottom", "degrees",
            NAV_SLOT(config.window.camera.fov_deg), within(0.1, 179)),
      key_of("window.camera.orthographic", "the 3D view is a parallel projection", "",
             NAV_SLOT(config.window.camera.orthographic)),
      value("window.camera.height_mm", "height of a parallel projection", "mm",
            NAV_SLOT(config.window.camera.height_mm), within(0.001, 1e6)),
      key_of("window.cutaway.enabled", "cutaway, as edited", "",
             NAV_SLOT(config.window.cutaway.enabled)),
      value("window.cutaway.theta1_deg", "angle of the inner surface, as edited", "degrees",
            NAV_SLOT(config.window.cutaway.theta1_deg), within(0, 90)),
      value("window.cutaway.theta2_deg", "angle of the outer surface, as edited", "degrees",
            NAV_SLOT(config.window.cutaway.theta2_deg), within(0, 90)),
      value("window.cutaway.overlay_mm", "depth of the overlay, as edited", "mm",
            NAV_SLOT(config.window.cutaway.overlay_mm),
            within(0, std::numeric_limits<double>::infinity())),
      value("window.cutaway.emphasis", "emphasis of shading, as edited", "",
            NAV_SLOT(config.window.cutaway.emphasis), within(0, 1)),
      choice("window.cutaway.style", "style of shading, as edited",
             NAV_SLOT(config.window.cutaway.style), {"phong", "gooch"}),
      embedded(
          "window.transfer", "transfer function as edited, JSON of an appearance",
          [](Section& section, const char* key, Settings& s) {
            read_embedded(section, key, s.config.window.transfer, parse_appearance_text);
          },
          [](KeyWriter& writer, const char* key, const Settings& s) {
            write_text(writer, key, s.config.window.transfer);
          }),
      embedded(
          "window.predicate_set",
          "predicate set as edited, before the strokes, JSON; none: an empty set",
          [](Section& section, const char* key, Settings& s) {
            read_embedded(section, key, s.config.window.predicate_set,
                          [](const std::string& name, const std::string& text) {
                            return text == "none" ? Result<PredicateFile>(PredicateFile{})
                                                  : parse_predicate_text(name, text);
                          });
          },
          [](KeyWriter& writer, const char* key, const Settings& s) {
            write_text(writer, key, s.config.window.predicate_set);
          }),
      embedded(
          "window.strokes", "scribbles on slices, JSON",
          [](Section& section, const char* key, Settings& s) {
            read_embedded(section, key, s.config.window.strokes, parse_scribble_text);
          },
          [](KeyWriter& writer, const char* key, const Settings& s) {
            write_text(writer, key, s.config.window.strokes);
          }),
      value("window.predicate", "chosen bar of the predicate histogram, from 1", "",
            NAV_SLOT(config.window.predicate), within(1, 64))};
  rows.insert(rows.end(), state.begin(), state.end());
}

}  // namespace nav::app
