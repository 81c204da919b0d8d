// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Options of the 3D view and of the appearance.
#include <algorithm>

#include "app/appearance/preset_folder.hpp"
#include "app/options/option_checks.hpp"
#include "app/options/option_rows.hpp"
#include "app/options/retired.hpp"
#include "app/options/session_appearance.hpp"
#include "app/options/session_objects.hpp"
#include "app/views/panels.hpp"

namespace nav::app {
namespace {

const std::vector<std::string_view> kDrawing{"demo", "replay", "live"};
const std::vector<std::string_view> kAll{"demo", "replay", "live", "register", "slices"};

bool is_simulated(const Settings& s) {
  return s.config.source.kind == SessionConfig::SourceKind::kSimulated;
}

/// The options of replay are read into a recording, those of demo into none.
bool has_needle(const Settings& s) {
  return is_simulated(s) || !s.config.source.needle_frame.empty();
}

Requirement composite() { return {.any_of = {{"--projection", {"composite"}}}}; }

/// The CT is drawn, not 3D ultrasound instead of it.
std::vector<Condition> ultrasound_alone() { return {{"--us-alone"}}; }

std::vector<Condition> no_cutaway() { return {{"--no-cutaway"}}; }

void want_cutaway(Settings& s) { s.config.appearance.cutaway.enabled = true; }

Requirement needle_to_cut() {
  return {.met =
              [](const Settings& s) {
                return has_needle(s) || !s.config.appearance.cutaway.around_needle.value_or(false);
              },
          .text = "--needle-frame for the needle",
          .verb = "replay"};
}

Requirement targets_to_cut() {
  return {.met =
              [](const Settings& s) {
                return is_simulated(s) || s.config.plan.has_value() ||
                       !s.config.appearance.cutaway.around_targets.value_or(false);
              },
          .text = "a session file with a plan for the targets",
          .verb = "replay"};
}

Requirement room_for_panel() {
  return {.met =
              [](const Settings& s) {
                return is_simulated(s) || has_panels(s.config.output.width, s.config.output.height);
              },
          .text = "a larger 3D view, beside which the CT fits",
          .found =
              [](const Settings& s) {
                return std::to_string(s.config.output.width) + " x " +
                       std::to_string(s.config.output.height);
              },
          .verb = "replay"};
}

/// LOW:HIGH=IMPORTANCE, or COMPONENT:LOW:HIGH=IMPORTANCE.
Result<render::ImportanceRule> importance_rule(const std::string& text) {
  const Error refused = unreadable("[COMPONENT:]LOW:HIGH=IMPORTANCE", text);
  const auto equals = text.rfind('=');
  if (equals == std::string::npos) return refused;
  const auto high = text.rfind(':', equals);
  if (high == std::string::npos || high == 0) return refused;
  const auto low = text.rfind(':', high - 1);
  const std::size_t low_begin = low == std::string::npos ? 0 : low + 1;
  render::ImportanceRule rule{0, 0, 0, low == std::string::npos ? "" : text.substr(0, low)};
  const auto number = [&](std::size_t begin, std::size_t end, double& value) {
    const std::string piece = text.substr(begin, end - begin);
    return CLI::detail::lexical_cast(piece, value);
  };
  if (!number(low_begin, high, rule.low_hu) || !number(high + 1, equals, rule.high_hu) ||
      !number(equals + 1, text.size(), rule.importance)) {
    return refused;
  }
  return rule;
}

Result<void> take_importance(Settings& s, const std::vector<std::string>& rules) {
  s.config.appearance.importance.clear();
  for (const std::string& text : rules) {
    const auto rule = importance_rule(text);
    if (!rule) return rule.error();
    s.config.appearance.importance.push_back(*rule);
  }
  return {};
}

Result<void> take_cut_objects(Settings& s, const std::vector<std::string>& kinds) {
  const std::vector<std::string> known{"plane", "needle", "targets"};
  for (const std::string& kind : kinds) {
    if (std::ranges::count(known, kind) == 0) {
      return Error{ErrorCode::kUsage, "expected " + listed(known) + ", found " + kind};
    }
  }
  const auto has = [&](const char* kind) { return std::ranges::count(kinds, kind) > 0; };
  auto& cutaway = s.config.appearance.cutaway;
  cutaway.around_plane = has("plane");
  cutaway.around_needle = has("needle");
  cutaway.around_targets = has("targets");
  return {};
}

Result<void> take_meshes(Settings& s, const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    CutawayObject object;
    object.type = CutawayObject::Type::kMesh;
    object.file = file;
    s.config.cutaway_objects.push_back(object);
  }
  return {};
}

}  // namespace

void add_view_rows(std::vector<Option>& rows) {
  const std::vector<Option> view{
      {.name = "--engine",
       .type = "NAME",
       .text = "rendering engine",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.output.engine),
       .choices = {"cpu", "gl", "reference"},
       .usual = true,
       .key = "output.engine"},
      {.name = "--threads",
       .type = "N",
       .text = "threads of the engine; 0: all cores",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.output.threads),
       .range = within(0, 1024),
       .key = "output.threads"},
      {.name = "--width",
       .type = "N",
       .unit = "pixels",
       .text = "width of the 3D view; 2D panels are added beside it",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.output.width),
       .range = within(16, 8192),
       .usual = true,
       .key = "output.width_px"},
      {.name = "--height",
       .type = "N",
       .unit = "pixels",
       .text = "height of the 3D view",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.output.height),
       .range = within(16, 8192),
       .usual = true,
       .key = "output.height_px"},
      {.name = "--rms-error",
       .type = "X",
       .text =
           "root mean square error of the colours of the image; the engine chooses its sampling "
           "distance for it",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.output.rms_error),
       .range = within(1e-5, 1),
       .key = "output.rms_error",
       .idle_with = ultrasound_alone(),
       .excludes = {"--pixel-error"},
       .before = [](Settings& s) { s.config.output.step_voxels.reset(); }},
      {.name = "--step",
       .type = "X",
       .unit = "voxels",
       .text = "sampling distance, instead of --rms-error",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.output.step_voxels),
       .range = within(1.0 / 64, 16),
       .absent = "chosen for --rms-error",
       .key = "output.step_voxels",
       .excludes = {"--rms-error"}},
      {.name = "--pixel-error",
       .type = "X",
       .text = "interpolate pixels whose neighbouring rays differ by less than this; 0 casts every "
               "ray",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.output.pixel_error),
       .range = within(0, 1),
       .key = "output.pixel_error",
       .needs = {{.any_of = {{"--engine", {"cpu", "gl"}}}}},
       .idle_with = {{"--us-volume"}},
       .always = {{.met =
                       [](const Settings& s) {
                         return !s.config.quality.jitter || s.config.output.pixel_error == 0;
                       },
                   .text = "0 beside quality.jitter, with which every pixel has its ray",
                   .found =
                       [](const Settings& s) {
                         return found_number(s.config.output.pixel_error);
                       }}}},
      {.name = "--classification",
       .type = "NAME",
       .text = "conversion of values between samples into colours; appearances with windows on the "
               "gradient are always post-classified",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.quality.classification),
       .choices = {"pre-integrated", "post-classified"},
       .key = "quality.classification",
       .needs = {composite()},
       .idle_with = ultrasound_alone()},
      {.name = "--jitter",
       .text = "start rays at different parts of a step: noise instead of rings",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.quality.jitter),
       .key = "quality.jitter"},
      {.name = "--adaptive-error",
       .type = "X",
       .text = "error of merged cells, no longer supported",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .absent = "none",
       .key = "quality.adaptive_error",
       .retired = kNoAdaptiveStep},
      {.name = "--azimuth",
       .type = "DEG",
       .unit = "degrees",
       .text = "direction of the camera: 0 from the front, 90 from the patient's left",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.view.azimuth_deg),
       .range = within(-360, 360),
       .absent = "without both angles, chosen so that the plane is well seen",
       .usual = true,
       .key = "view.azimuth_deg"},
      {.name = "--elevation",
       .type = "DEG",
       .unit = "degrees",
       .text = "direction of the camera, from above",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.view.elevation_deg),
       .range = within(-89, 89),
       .absent = "as --azimuth",
       .usual = true,
       .key = "view.elevation_deg"},
      {.name = "--distance",
       .type = "MM",
       .unit = "mm",
       .text = "distance of the camera; 0: the CT about fills the view, or nearer, so that the "
               "ultrasound plane takes a third of it",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.view.distance_mm),
       .range = within(0, 1e5),
       .key = "view.distance_mm"},
      {.name = "--fov",
       .type = "DEG",
       .unit = "degrees",
       .text = "field of view from top to bottom",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.view.fov_deg),
       .range = within(1, 120),
       .key = "view.fov_deg"},
      {.name = "--orthographic",
       .text = "draw a parallel projection; the centre of the view keeps its size",
       .group = group::kGroupView,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.view.orthographic),
       .key = "view.orthographic"},
      {.name = "--window-level",
       .type = "HU",
       .unit = "HU",
       .text = "middle of the grey window of the 2D images of the CT",
       .group = group::kGroupWindow,
       .verbs = kAll,
       .slot = NAV_SLOT(config.view.window_level),
       .range = within(-1e6, 1e6),
       .absent = "automatic",
       .usual = true,
       .key = "view.window_level",
       .needs = {room_for_panel(),
                 sweep_to_register(),
                 {.any_of = {{"--out"}}, .verb = "register"}}},
      {.name = "--window-width",
       .type = "HU",
       .unit = "HU",
       .text = "extent of the grey window of the 2D images of the CT, from black to white",
       .group = group::kGroupWindow,
       .verbs = kAll,
       .slot = NAV_SLOT(config.view.window_width),
       .range = within(1e-3, 1e6),
       .absent = "automatic",
       .usual = true,
       .key = "view.window_width",
       .needs = {
           room_for_panel(), sweep_to_register(), {.any_of = {{"--out"}}, .verb = "register"}}}};
  rows.insert(rows.end(), view.begin(), view.end());
}

void add_appearance_rows(std::vector<Option>& rows) {
  const std::vector<Option> colours{
      {.name = "--transfer-function",
       .type = "NAME",
       .text = "preset of colours and opacities",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.preset),
       .choices = all_preset_names(),
       .choices_from = preset_folder(),
       .usual = true,
       .key = "look.transfer_function",
       .needs = {composite()},
       .idle_with = ultrasound_alone(),
       .excludes = {"--appearance"},
       .before =
           [](Settings& s) {
             s.config.appearance.nodes.clear();
             s.config.appearance.file.clear();
           }},
      {.type = "LIST",
       .text = "nodes of the transfer function instead of a preset, a list of tables: hu and "
               "opacity_per_mm, and optionally rgb (white) and importance (0.5)",
       .group = group::kGroupAppearance,
       .absent = "none",
       .key = "look.nodes",
       .read = read_appearance_nodes,
       .write = write_appearance_nodes},
      {.name = "--appearance",
       .type = "FILE",
       .text = "appearance file, or a volume property of 3D Slicer (.vp, .vp.json), instead of a "
               "preset",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.file),
       .absent = "none",
       .usual = true,
       .key = "look.file",
       .written_when_set = true,
       .needs = {composite()},
       .formerly = "--look"},
      {.name = "--save-appearance",
       .type = "FILE",
       .text = "store the appearance as it is drawn, for --appearance on other data",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.save),
       .absent = "none",
       .key = "look.save",
       .written_when_set = true,
       .needs = {composite()},
       .idle_with = ultrasound_alone(),
       .formerly = "--save-look"},
      {.name = "--importance",
       .type = "[COMPONENT:]LOW:HIGH=I",
       .unit = "HU",
       .text = "importance I of a range of values, 0 to 1; may be repeated",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .absent = "from the appearance",
       .repeats = true,
       .key = "look.importance",
       .needs = {composite()},
       .idle_with = ultrasound_alone(),
       .take = take_importance,
       .read = read_appearance_importance,
       .write = write_appearance_importance},
      {.name = "--blood-at",
       .type = "MM",
       .unit = "mm",
       .text =
           "point in a vessel with contrast agent, LPS; the vessels of the appearance are fitted "
           "to its values",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.blood_at_mm),
       .range = of_point(),
       .absent = "found in the histogram of the CT",
       .key = "look.blood_at_mm",
       .needs = {composite()},
       .idle_with = {{"--us-alone"}, {"--no-vessel-fit"}}},
      {.name = "--least-vessel",
       .type = "ML",
       .unit = "ml",
       .text = "volume of the smallest separate part of vessels that is drawn",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.least_vessel_ml),
       .range = within(0, 1e6),
       .key = "look.least_vessel_ml",
       .needs = {composite()},
       .idle_with = {{"--us-alone"}, {"--no-vessel-fit"}}},
      {.name = "--no-vessel-fit",
       .text = "draw vessels by the fixed window of the appearance, with bone of the same values",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.fit_vessels),
       .negates = true,
       .key = "look.vessel_fit",
       .needs = {composite()},
       .idle_with = ultrasound_alone()},
      {.name = "--keep-table",
       .text = "also draw the table, clothes and cables beside the body",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.remove_table),
       .negates = true,
       .key = "look.remove_table",
       .needs = {composite()},
       .idle_with = ultrasound_alone()},
      {.name = "--shading-smoothing",
       .type = "MM",
       .unit = "mm",
       .text = "standard deviation of the Gaussian that smooths the CT for the gradients of the "
               "shading; 0: none",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.smoothing_mm),
       .range = within(0, 20),
       .absent = "from the appearance, or 0",
       .key = "look.smoothing_mm",
       .needs = {composite()},
       .idle_with = {{"--us-alone"}, {"--no-shading"}}},
      {.name = "--no-shading",
       .text = "draw without shading",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.shading),
       .negates = true,
       .key = "look.shading",
       .needs = {composite()},
       .idle_with = ultrasound_alone()},
      {.name = "--shading",
       .type = "NAME",
       .text = "style of the shading",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.style),
       .choices = {"phong", "gooch"},
       .absent = "from the appearance, or phong",
       .key = "look.style",
       .needs = {composite()},
       .idle_with = {{"--us-alone"}, {"--no-shading"}}},
      {.name = "--emphasis",
       .type = "X",
       .text = "shade in proportion to importance; 0: shade everything",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.emphasis),
       .range = within(0, 1),
       .absent = "from the appearance, or 0",
       .key = "look.emphasis",
       .needs = {composite()},
       .idle_with = {{"--us-alone"}, {"--no-shading"}}},
      {.name = "--plane-opacity",
       .type = "X",
       .text = "opacity of the ultrasound image in the 3D view",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.plane_opacity),
       .range = within(0.01, 1),
       .key = "look.plane_opacity"},
      {.name = "--plane-texture",
       .type = "NAME",
       .text = "image on the live plane in the 3D view: the ultrasound, or the CT along it",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.plane_texture),
       .choices = {"ultrasound", "ct"},
       .key = "look.plane_texture"},
      {.name = "--projection",
       .type = "NAME",
       .text = "draw colours, or a grey projection",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.projection),
       .choices = {"composite", "maximum", "minimum", "mean"},
       .usual = true,
       .key = "look.projection"},
      {.name = "--grey-level",
       .type = "HU",
       .unit = "HU",
       .text = "middle of the grey window of a projection",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.grey_level_hu),
       .range = within(-1e6, 1e6),
       .absent = "automatic",
       .key = "look.grey_level_hu",
       .needs = {{.any_of = {{"--projection", {"maximum", "minimum", "mean"}}}}}},
      {.name = "--grey-width",
       .type = "HU",
       .unit = "HU",
       .text = "extent of the grey window of a projection, from black to white",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.grey_width_hu),
       .range = above(0, 1e6),
       .absent = "automatic",
       .key = "look.grey_width_hu",
       .needs = {{.any_of = {{"--projection", {"maximum", "minimum", "mean"}}}}}}};
  const std::vector<Option> cutaway{
      {.name = "--cutaway-inner",
       .type = "DEG",
       .unit = "degrees",
       .text = "angle of the inner surface of the cutaway about the line of sight",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.cutaway.theta1_deg),
       .range = within(0.1, 89.9),
       .absent = "from the appearance, or 30",
       .key = "look.cutaway.theta1_deg",
       .needs = {composite()},
       .idle_with = no_cutaway(),
       .always = {{.met =
                       [](const Settings& s) {
                         const auto& given = s.config.appearance.cutaway;
                         return !given.theta1_deg || !given.theta2_deg ||
                                *given.theta1_deg <= *given.theta2_deg;
                       },
                   .text = "at most theta2_deg",
                   .found =
                       [](const Settings& s) {
                         return found_number(*s.config.appearance.cutaway.theta1_deg);
                       }}},
       .before = want_cutaway},
      {.name = "--cutaway-outer",
       .type = "DEG",
       .unit = "degrees",
       .text = "angle of the outer surface of the cutaway, at least the inner one",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.cutaway.theta2_deg),
       .range = within(0.1, 89.9),
       .absent = "from the appearance, or 50",
       .key = "look.cutaway.theta2_deg",
       .more_keys = {"look.cutaway.theta1_deg"},
       .needs = {composite()},
       .idle_with = no_cutaway(),
       .before = want_cutaway},
      {.name = "--cutaway-overlay",
       .type = "MM",
       .unit = "mm",
       .text = "depth in front of the plane in which important structures stay; inf: all of it",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.cutaway.overlay_mm),
       .range = Range{.low = 0},
       .absent = "from the appearance, or 15",
       .key = "look.cutaway.overlay_mm",
       .needs = {composite()},
       .idle_with = no_cutaway(),
       .before = want_cutaway},
      {.name = "--cutaway-thresholds",
       .type = "X",
       .text = "occlusions between which everything fades whatever its importance (Burns et al. "
               "2007, 3.4); 0 1: evenly from the outer surface on",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.cutaway.constant),
       .range = within(0, 1),
       .absent = "from the importance",
       .key = "look.cutaway.constant_thresholds",
       .needs = {composite()},
       .idle_with = no_cutaway(),
       .before = want_cutaway},
      {.name = "--cutaway-around",
       .type = "LIST",
       .text = "objects that are cut free: plane, needle, targets, separated by commas",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .absent = "from the appearance, or plane",
       .repeats = true,
       .delimiter = ',',
       .more_keys = {"look.cutaway.around_plane", "look.cutaway.around_needle",
                     "look.cutaway.around_targets"},
       .needs = {composite(), needle_to_cut(), targets_to_cut()},
       .idle_with = no_cutaway(),
       .take = take_cut_objects,
       .before = want_cutaway},
      {.text = "cut the ultrasound plane free",
       .group = group::kGroupAppearance,
       .slot = NAV_SLOT(config.appearance.cutaway.around_plane),
       .absent = "from the appearance, or true",
       .key = "look.cutaway.around_plane"},
      {.text = "cut the needle free",
       .group = group::kGroupAppearance,
       .slot = NAV_SLOT(config.appearance.cutaway.around_needle),
       .absent = "from the appearance, or false",
       .key = "look.cutaway.around_needle"},
      {.text = "cut the targets of the plan free",
       .group = group::kGroupAppearance,
       .slot = NAV_SLOT(config.appearance.cutaway.around_targets),
       .absent = "from the appearance, or false",
       .key = "look.cutaway.around_targets"},
      {.name = "--cutaway-mesh",
       .type = "FILE",
       .text =
           "surface that is also cut free: .stl, .ply or .vtk in the coordinates of the CT; may "
           "be repeated",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .absent = "none",
       .repeats = true,
       .key = "cutaway_objects",
       .needs = {composite()},
       .idle_with = no_cutaway(),
       .take = take_meshes,
       .before = want_cutaway,
       .read = read_cutaway_list,
       .write = write_cutaway_list},
      // The last of the cutaway, so that it wins over the others, which are then rejected.
      {.name = "--no-cutaway",
       .text = "cut nothing; without it, each of the five options above turns the cutaway on",
       .group = group::kGroupAppearance,
       .verbs = kDrawing,
       .slot = NAV_SLOT(config.appearance.cutaway.enabled),
       .negates = true,
       .key = "look.cutaway.enabled",
       .needs = {composite()}}};
  rows.insert(rows.end(), colours.begin(), colours.end());
  rows.insert(rows.end(), cutaway.begin(), cutaway.end());
}

}  // namespace nav::app
