// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Options of 3D ultrasound: scan lines and labels, the predicate set, strokes, the image.
#include "app/options/option_checks.hpp"
#include "app/options/option_rows.hpp"
#include "app/options/session_predicates.hpp"
#include "app/predicates/predicate_scribbles.hpp"
#include "sim/predicate_patient.hpp"

namespace nav::app {
namespace {

using Values = std::vector<std::string>;
using render::features::Paint;

const std::vector<std::string_view> kUltrasound{"predicates", "replay", "window"};

/// In a window: a volume that it shows alone.
Requirement volume_in_window() {
  return {.met =
              [](const Settings& s) {
                return !s.config.predicates.volume.empty() || !s.window.phantom.empty();
              },
          .text = "--us-volume or --phantom",
          .verb = "window"};
}
Requirement no_session_in_window() {
  return {.met = [](const Settings& s) { return s.session.empty() && !s.window.simulated; },
          .text = "neither a session file (its [predicates] names the volume) nor --simulated",
          .verb = "window"};
}

Requirement volume_in_replay() { return {.any_of = {{"--us-volume"}}, .verb = "replay"}; }

/// Options of scan lines replace all that a session file says of them.
void replace_lines(Settings& s) {
  PredicateOptions& o = s.config.predicates;
  o.into_ct.reset();
  o.face_ct.reset();
  o.apex_ct.reset();
  o.scan_lines.clear();
}
/// Needs of options of a volume that predicates draw, wherever it comes from.
std::vector<Requirement> where_a_volume_is() {
  return {recording_session(), volume_in_replay(), volume_in_window()};
}

template <class Parse>
Result<void> add_edits(Settings& s, const Values& texts, Parse parse) {
  for (const std::string& text : texts) {
    auto edit = parse(text);
    if (!edit) return edit.error();
    s.config.predicates.histogram.push_back(*std::move(edit));
  }
  return {};
}

Result<void> take_importances(Settings& s, const Values& texts) {
  return add_edits(s, texts, parse_importance);
}

Result<void> take_floors(Settings& s, const Values& texts) {
  return add_edits(s, texts, parse_floor);
}

Result<void> take_colours(Settings& s, const Values& texts) {
  return add_edits(s, texts, parse_colour);
}

Result<void> add_strokes(Settings& s, const Values& texts, Paint paint) {
  for (const std::string& text : texts) {
    auto stroke = parse_stroke(paint == Paint::kShow ? "--show" : "--hide", paint, text);
    if (!stroke) return stroke.error();
    s.config.predicates.strokes.push_back(*std::move(stroke));
  }
  return {};
}

void add_set_rows(std::vector<Option>& rows) {
  const std::vector<Option> set{
      {.name = "--predicates",
       .type = "NAME|FILE",
       .text = "predicate set: a preset, or a file",
       .group = group::kGroupPredicateSet,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.set_up),
       .usual = true,
       .key = "predicates.set_up",
       .needs = where_a_volume_is(),
       .read = read_predicate_set,
       .write = write_predicate_set},
      {.name = "--importance",
       .type = "NAME=I",
       .text =
           "importance I of a bar of the predicate histogram, 0 to 1; may be repeated, in order",
       .group = group::kGroupPredicateSet,
       .verbs = {"predicates", "window"},
       .absent = "from the set",
       .repeats = true,
       .key = "predicates.histogram",
       .more_keys = {"predicates.histogram.importance"},
       .needs = {volume_in_window()},
       .take = take_importances,
       .read = read_histogram,
       .write = write_histogram},
      {.name = "--colour",
       .type = "NAME=HUE:SATURATION",
       .unit = "degrees, share",
       .text = "colour of a bar of the predicate histogram, hue modulo 360; may be repeated",
       .group = group::kGroupPredicateSet,
       .verbs = {"predicates", "window"},
       .absent = "from the set",
       .repeats = true,
       .more_keys = {"predicates.histogram", "predicates.histogram.hue_deg",
                     "predicates.histogram.saturation"},
       .needs = {volume_in_window()},
       .take = take_colours},
      {.name = "--floor",
       .type = "NAME=F",
       .text = "least intensity, and so luminance and opacity, of voxels for which a predicate is "
               "true, 0 to 1; may be repeated",
       .group = group::kGroupPredicateSet,
       .verbs = kUltrasound,
       .absent = "from the set, or none",
       .repeats = true,
       .more_keys = {"predicates.histogram", "predicates.histogram.floor"},
       .needs = where_a_volume_is(),
       .take = take_floors},
      {.name = "--soft",
       .type = "X",
       .text = "width of soft thresholds as a share of each: a ramp in place of a step; 0: steps",
       .group = group::kGroupPredicateSet,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.soft_share),
       .range = within(0, 1),
       .absent = "from the set, or 0",
       .key = "predicates.soft",
       .needs = where_a_volume_is()},
      {.name = "--phong",
       .type = "MM",
       .unit = "mm",
       .text = "shade by Phong, by the gradient of the volume smoothed by this standard deviation; "
               "0: no shading",
       .group = group::kGroupPredicateSet,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.shading_mm),
       .range = within(0, 20),
       .absent = "from the set, or 0",
       .key = "predicates.phong_mm",
       .needs = where_a_volume_is()},
      {.name = "--predicate-importance",
       .type = "NAME=I",
       .text =
           "importance I of a bar of the predicate histogram, 0 to 1; may be repeated, in order",
       .group = group::kGroupPredicateSet,
       .verbs = {"replay"},
       .absent = "from the set",
       .repeats = true,
       .more_keys = {"predicates.histogram", "predicates.histogram.importance"},
       .needs = where_a_volume_is(),
       .take = take_importances},
      {.name = "--predicate-colour",
       .type = "NAME=HUE:SATURATION",
       .unit = "degrees, share",
       .text = "colour of a bar of the predicate histogram, hue modulo 360; may be repeated",
       .group = group::kGroupPredicateSet,
       .verbs = {"replay"},
       .absent = "from the set",
       .repeats = true,
       .more_keys = {"predicates.histogram", "predicates.histogram.hue_deg",
                     "predicates.histogram.saturation"},
       .needs = where_a_volume_is(),
       .take = take_colours},
      {.name = "--hue-mean",
       .type = "NAME",
       .text = "mean hue of predicates that are true together; linear: as the paper prints it",
       .group = group::kGroupPredicateSet,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.hue_mean),
       .choices = {"circular", "linear"},
       .absent = "from the set",
       .key = "predicates.hue_mean",
       .needs = where_a_volume_is()},
      {.name = "--save",
       .type = "FILE",
       .text = "store the predicate set as it was drawn",
       .group = group::kGroupPredicateSet,
       .verbs = {"predicates"},
       .slot = NAV_SLOT(config.predicates.save_set_up),
       .absent = "none",
       .key = "predicates.save_set_up",
       .written_when_set = true},
      {.name = "--opacity-length-mm",
       .type = "MM",
       .unit = "mm",
       .text = "thickness of material in which intensity equals opacity",
       .group = group::kGroupPredicateSet,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.opacity_length_mm),
       .range = within(1e-3, 1e4),
       .absent = "from the set",
       .key = "predicates.opacity_length_mm",
       .needs = where_a_volume_is()},
      {.name = "--smoothing-mm",
       .type = "MM",
       .unit = "mm",
       .text = "smoothing of gradients",
       .group = group::kGroupPredicateSet,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.smoothing_mm),
       .range = within(0, 20),
       .absent = "from the set",
       .key = "predicates.smoothing_mm",
       .needs = where_a_volume_is()},
      {.name = "--smallest-radius",
       .type = "MM",
       .unit = "mm",
       .text = "smallest radius of vessels",
       .group = group::kGroupPredicateSet,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.smallest_radius_mm),
       .range = within(1e-3, 100),
       .absent = "from the set",
       .key = "predicates.smallest_radius_mm",
       .needs = where_a_volume_is()},
      {.name = "--largest-radius",
       .type = "MM",
       .unit = "mm",
       .text = "largest radius of vessels, at least the smallest",
       .group = group::kGroupPredicateSet,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.largest_radius_mm),
       .range = within(1e-3, 100),
       .absent = "from the set",
       .key = "predicates.largest_radius_mm",
       .needs = where_a_volume_is()},
      {.name = "--bright",
       .text = "vessels are brighter than their surroundings",
       .group = group::kGroupPredicateSet,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.bright_vessels),
       .absent = "from the set",
       .key = "predicates.bright_vessels",
       .needs = where_a_volume_is(),
       .excludes = {"--dark"}},
      {.name = "--dark",
       .text = "vessels are darker than their surroundings",
       .group = group::kGroupPredicateSet,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.bright_vessels),
       .absent = "from the set",
       .negates = true,
       .needs = where_a_volume_is()}};
  rows.insert(rows.end(), set.begin(), set.end());
}

void add_scan_rows(std::vector<Option>& rows) {
  const std::vector<Option> lines{
      {.name = "--into",
       .type = "X",
       .text = "direction of parallel scan lines, away from the probe, LPS",
       .group = group::kGroupScanLines,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.into_ct),
       .absent = "none",
       .key = "predicates.into",
       .needs = where_a_volume_is(),
       .excludes = {"--apex", "--scan-lines"},
       .before = replace_lines},
      {.name = "--face",
       .type = "X",
       .unit = "mm",
       .text = "point of the plane where parallel scan lines have depth 0, LPS",
       .group = group::kGroupScanLines,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.face_ct),
       .absent = "the known voxel nearest to the probe",
       .key = "predicates.face_mm",
       .needs = where_a_volume_is()},
      {.name = "--apex",
       .type = "X",
       .unit = "mm",
       .text = "apex of a fan of scan lines, LPS",
       .group = group::kGroupScanLines,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.apex_ct),
       .absent = "none",
       .key = "predicates.apex_mm",
       .needs = where_a_volume_is(),
       .excludes = {"--scan-lines"},
       .before = replace_lines},
      {.name = "--face-radius-mm",
       .type = "MM",
       .unit = "mm",
       .text = "radius of the probe face of a fan",
       .group = group::kGroupScanLines,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.face_radius_mm),
       .range = within(0, 1e4),
       .key = "predicates.face_radius_mm",
       .needs =
           {recording_session(), volume_in_replay(), volume_in_window(), {.any_of = {{"--apex"}}}}},
      {.name = "--scan-lines",
       .type = "FILE",
       .text = "file of the planes of the sweep that the volume was made from",
       .group = group::kGroupScanLines,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.scan_lines),
       .absent = "none",
       .key = "predicates.scan_lines",
       .written_when_set = true,
       .needs = where_a_volume_is(),
       .before = replace_lines},
      {.name = "--black",
       .type = "X",
       .unit = "stored values",
       .text = "stored value of no intensity",
       .group = group::kGroupScanLines,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.black),
       .range = within(-1e6, 1e6),
       .absent = "0, or for dim and bright volumes a percentile",
       .key = "predicates.black",
       .needs = where_a_volume_is()},
      {.name = "--white",
       .type = "X",
       .unit = "stored values",
       .text = "stored value of full intensity",
       .group = group::kGroupScanLines,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.white),
       .range = within(-1e6, 1e6),
       .absent = "255, or for dim and bright volumes a percentile",
       .usual = true,
       .key = "predicates.white",
       .needs = where_a_volume_is()},
      {.name = "--labels",
       .type = "FILE",
       .text = "label volume of bit masks; repeated: one bit for each file, set where its value is "
               "not 0",
       .group = group::kGroupScanLines,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.labels),
       .absent = "none",
       .repeats = true,
       .key = "predicates.labels",
       .needs = where_a_volume_is(),
       .excludes = {"--layers"},
       .before = [](Settings& s) { s.config.predicates.layers.clear(); }},
      {.name = "--layers",
       .type = "FILE",
       .text = "file of B-spline surfaces between layers, instead of labels",
       .group = group::kGroupScanLines,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.layers),
       .absent = "none",
       .key = "predicates.layers",
       .written_when_set = true,
       .needs = where_a_volume_is(),
       .before = [](Settings& s) { s.config.predicates.labels.clear(); }},
      {.name = "--unknown",
       .type = "N",
       .unit = "stored values",
       .text = "stored value of voxels that no image reached",
       .group = group::kGroupScanLines,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.unknown),
       .range = within(-32768, 32767),
       .absent = "none",
       .key = "predicates.unknown",
       .needs = where_a_volume_is()},
      {.name = "--cache",
       .type = "DIR",
       .text = "folder that stores derived features for the next run",
       .group = group::kGroupScanLines,
       .verbs = kUltrasound,
       .slot = NAV_SLOT(config.predicates.cache),
       .absent = "none",
       .key = "predicates.cache",
       .written_when_set = true,
       .needs = where_a_volume_is()}};
  rows.insert(rows.end(), lines.begin(), lines.end());
}

}  // namespace

Requirement ultrasound_volume() { return volume_in_replay(); }

void add_volume_rows(std::vector<Option>& rows) {
  const std::vector<Option> volume{
      {.name = "--us-volume",
       .type = "VOLUME",
       .text = "3D ultrasound in the CT's frame, drawn by predicates inside the CT",
       .group = group::kGroupVolume,
       .verbs = {"replay"},
       .slot = NAV_SLOT(config.predicates.volume),
       .absent = "none",
       .usual = true,
       .key = "predicates.volume",
       .written_when_set = true,
       .needs = {recording_session(),
                 {.met =
                      [](const Settings& s) {
                        return s.config.predicates.alone ||
                               s.config.appearance.projection == "composite";
                      },
                  .text = "--us-alone or --projection composite",
                  .found = [](const Settings& s) { return s.config.appearance.projection; }}}},
      {.name = "--us-volume",
       .type = "VOLUME",
       .text = "show this 3D ultrasound, drawn by predicates, without a CT",
       .group = group::kGroupVolume,
       .verbs = {"window"},
       .slot = NAV_SLOT(config.predicates.volume),
       .absent = "none",
       .usual = true,
       .needs = {no_session_in_window()}},
      {.name = "--phantom",
       .type = "NAME",
       .text = "show a phantom: neck, or a simulated patient (" +
               sim::simulated_ultrasound_names() + ")",
       .group = group::kGroupVolume,
       .verbs = {"window"},
       .slot = NAV_SLOT(window.phantom),
       .absent = "none",
       .usual = true,
       .needs = {no_session_in_window()},
       .excludes = {"--us-volume"}},
      {.name = "--phantom-side",
       .type = "N",
       .unit = "voxels",
       .text = "side of the phantom",
       .group = group::kGroupVolume,
       .verbs = {"window"},
       .slot = NAV_SLOT(config.predicates.phantom_side),
       .range = within(32, 512),
       .needs = {{.any_of = {{"--phantom"}}}}},
      {.name = "--us-alone",
       .text = "draw that volume instead of the CT",
       .group = group::kGroupVolume,
       .verbs = {"replay"},
       .slot = NAV_SLOT(config.predicates.alone),
       .key = "predicates.alone",
       .needs = {recording_session(), volume_in_replay()}},
      {.name = "--ct-importance",
       .type = "X",
       .text = "weight of the CT beside that volume; 1: as a predicate of average importance; 0: "
               "all ultrasound shines through",
       .group = group::kGroupVolume,
       .verbs = {"replay"},
       .slot = NAV_SLOT(config.predicates.ct_importance),
       .range = within(0, 1024),
       .key = "predicates.ct_importance",
       .needs = {recording_session(), volume_in_replay()},
       .idle_with = {{"--us-alone"}}},
      {.name = "--phantom",
       .type = "NAME",
       .text = "phantom without a volume: neck, or a simulated patient (" +
               sim::simulated_ultrasound_names() + ")",
       .group = group::kGroupVolume,
       .verbs = {"predicates"},
       .slot = NAV_SLOT(config.predicates.phantom),
       .usual = true,
       .key = "predicates.phantom",
       .idle_with = {{"volume"}}},
      {.name = "--phantom-side",
       .type = "N",
       .unit = "voxels",
       .text = "side of the phantom",
       .group = group::kGroupVolume,
       .verbs = {"predicates"},
       .slot = NAV_SLOT(config.predicates.phantom_side),
       .range = within(32, 512),
       .key = "predicates.phantom_side",
       .idle_with = {{"volume"}}}};
  rows.insert(rows.end(), volume.begin(), volume.end());
  add_set_rows(rows);
  add_scan_rows(rows);
}

void add_predicate_rows(std::vector<Option>& rows) {
  const std::vector<std::string_view> here{"predicates"};
  const std::vector<Option> strokes{
      {.name = "--scribbles",
       .type = "FILE",
       .text = "file of strokes painted on slices",
       .group = group::kGroupStrokes,
       .verbs = here,
       .slot = NAV_SLOT(config.predicates.scribbles),
       .absent = "none",
       .key = "predicates.scribbles",
       .written_when_set = true},
      {.name = "--show",
       .type = "STROKE",
       .unit = "mm",
       .text = "stroke over voxels to show, 'x,y,z x,y,z … [radius=MM] [thickness=MM] "
               "[normal=x,y,z]', LPS; may be repeated; the last one that covers a voxel counts",
       .group = group::kGroupStrokes,
       .verbs = here,
       .absent = "none",
       .repeats = true,
       .in_order = true,
       .take = [](Settings& s, const Values& v) { return add_strokes(s, v, Paint::kShow); }},
      {.name = "--hide",
       .type = "STROKE",
       .unit = "mm",
       .text = "stroke over voxels to hide, written as for --show",
       .group = group::kGroupStrokes,
       .verbs = here,
       .absent = "none",
       .repeats = true,
       .in_order = true,
       .take = [](Settings& s, const Values& v) { return add_strokes(s, v, Paint::kHide); }},
      {.name = "--scribble-share",
       .type = "X",
       .text = "share of the importance that strokes change",
       .group = group::kGroupStrokes,
       .verbs = {"predicates", "window"},
       .slot = NAV_SLOT(config.predicates.scribble_share),
       .range = within(1e-6, 1),
       .key = "predicates.scribble_share",
       .needs = {{.any_of = {{"--scribbles"}, {"--show"}, {"--hide"}}, .verb = "predicates"},
                 volume_in_window()}}};
  const std::vector<Option> image{
      {.name = "--from",
       .type = "X",
       .text = "position of the eye along the axes of the volume, from its middle",
       .group = group::kGroupImage,
       .verbs = {"predicates", "window"},
       .slot = NAV_SLOT(config.predicates.from),
       .usual = true,
       .key = "predicates.from",
       .needs = {volume_in_window()}},
      {.name = "--distance",
       .type = "MM",
       .unit = "mm",
       .text = "distance of the camera; 0: the volume fits",
       .group = group::kGroupImage,
       .verbs = here,
       .slot = NAV_SLOT(config.view.distance_mm),
       .range = within(0, 1e5),
       .key = "view.distance_mm"},
      {.name = "--orthographic",
       .text = "draw a parallel projection",
       .group = group::kGroupImage,
       .verbs = here,
       .slot = NAV_SLOT(config.view.orthographic),
       .key = "view.orthographic"},
      {.name = "--target",
       .type = "X",
       .unit = "mm",
       .text = "target sphere, x y z and radius, LPS: drawn, and used by target_distance",
       .group = group::kGroupImage,
       .verbs = {"predicates", "window"},
       .slot = NAV_SLOT(config.predicates.target),
       .absent = "none",
       .key = "predicates.target_mm",
       .needs = {volume_in_window()}},
      {.name = "--needle",
       .type = "X",
       .unit = "mm",
       .text = "tip and hub of a needle, LPS: drawn, and used by needle_distance",
       .group = group::kGroupImage,
       .verbs = here,
       .slot = NAV_SLOT(config.predicates.needle),
       .absent = "none",
       .key = "predicates.needle_mm"},
      {.name = "--engine",
       .type = "NAME",
       .text = "rendering engine",
       .group = group::kGroupImage,
       .verbs = here,
       .slot = NAV_SLOT(config.output.engine),
       .choices = {"cpu", "gl", "reference"},
       .usual = true,
       .key = "output.engine"},
      {.name = "--threads",
       .type = "N",
       .text = "threads of the engine; 0: all cores",
       .group = group::kGroupImage,
       .verbs = here,
       .slot = NAV_SLOT(config.output.threads),
       .range = within(0, 1024),
       .key = "output.threads"},
      {.name = "--width",
       .type = "N",
       .unit = "pixels",
       .text = "width of each part of the image",
       .group = group::kGroupImage,
       .verbs = here,
       .slot = NAV_SLOT(config.output.width),
       .range = within(200, 4096),
       .usual = true,
       .key = "output.width_px"},
      {.name = "--height",
       .type = "N",
       .unit = "pixels",
       .text = "height of each part of the image",
       .group = group::kGroupImage,
       .verbs = here,
       .slot = NAV_SLOT(config.output.height),
       .range = within(200, 4096),
       .usual = true,
       .key = "output.height_px"},
      {.name = "--step",
       .type = "X",
       .unit = "voxels",
       .text = "sampling distance",
       .group = group::kGroupImage,
       .verbs = here,
       .slot = NAV_SLOT(config.output.step_voxels),
       .range = within(1.0 / 64, 16),
       .absent = "0.5",
       .key = "output.step_voxels"}};
  rows.insert(rows.end(), strokes.begin(), strokes.end());
  rows.insert(rows.end(), image.begin(), image.end());
}

}  // namespace nav::app
