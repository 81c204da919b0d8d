// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/look_options.hpp"

#include <algorithm>

#include "app/options/option_checks.hpp"
#include "app/options/retired.hpp"

namespace nav::app {
namespace {

/// LOW:HIGH=IMPORTANCE, or COMPONENT:LOW:HIGH=IMPORTANCE.
Result<render::ImportanceRule> importance_rule(const std::string& text) {
  const auto refuse = [&] {
    return Error{ErrorCode::kUsage,
                 "--importance: expected [COMPONENT:]LOW:HIGH=IMPORTANCE, found '" + text + "'"};
  };
  const auto equals = text.rfind('=');
  if (equals == std::string::npos) return refuse();
  const auto high = text.rfind(':', equals);
  if (high == std::string::npos || high == 0) return refuse();
  const auto low = text.rfind(':', high - 1);
  const std::size_t low_begin = low == std::string::npos ? 0 : low + 1;
  render::ImportanceRule rule{0, 0, 0, low == std::string::npos ? "" : text.substr(0, low)};
  const auto number = [&](std::size_t begin, std::size_t end, double& value) {
    const std::string piece = text.substr(begin, end - begin);
    return CLI::detail::lexical_cast(piece, value);
  };
  if (!number(low_begin, high, rule.low_hu) || !number(high + 1, equals, rule.high_hu) ||
      !number(equals + 1, text.size(), rule.importance)) {
    return refuse();
  }
  return rule;
}

void add_cutaway_options(CLI::App& verb, SessionConfig::Look::Cutaway& cutaway) {
  // Whoever says how to cut wants it, whatever the look or the session says.
  const auto add = [&](const char* option, std::optional<double>& value, const char* description) {
    verb.add_option_function<double>(
        option,
        [&cutaway, &value](const double& given) {
          value = given;
          cutaway.enabled = true;
        },
        description);
  };
  add("--cutaway-inner", cutaway.theta1_deg,
      "angle of the inner surface of the cutaway, degrees: 30");
  add("--cutaway-outer", cutaway.theta2_deg, "of the outer one, degrees: 50");
  add("--cutaway-overlay", cutaway.overlay_mm,
      "depth in front of the plane that keeps what is important, mm: 15; inf: all");
  verb.add_option_function<std::vector<std::string>>(
          "--cutaway-around",
          [&cutaway](const std::vector<std::string>& kinds) {
            const auto has = [&](const char* kind) {
              return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
            };
            cutaway.around_plane = has("plane");
            cutaway.around_needle = has("needle");
            cutaway.around_targets = has("targets");
            cutaway.enabled = true;
          },
          "what is cut free, of plane, needle, targets: plane")
      ->delimiter(',')
      ->check(among({"plane", "needle", "targets"}));
  // The last, so that it is refused beside those instead of being overruled.
  verb.add_flag_callback(
      "--no-cutaway", [&cutaway] { cutaway.enabled = false; }, "show everything in front too");
}

}  // namespace

void add_look_options(CLI::App& verb, SessionConfig::Look& look) {
  std::string presets;
  for (const std::string& name : render::preset_names()) {
    presets += (presets.empty() ? "" : ", ") + name;
  }
  auto* preset = verb.add_option_function<std::string>(
                         "--transfer-function",
                         [&look](const std::string& name) {
                           look.preset = name;
                           look.nodes.clear();  // Those of a session, which an option replaces.
                           look.file.clear();
                         },
                         presets)
                     ->check(among(render::preset_names()))
                     ->default_str(look.preset);
  verb.add_option("--look", look.file,
                  "look file, or a volume property of 3D Slicer (.vp, .vp.json)")
      ->excludes(preset);
  verb.add_option("--save-look", look.save,
                  "stores the look as it is drawn, for --look on other data");
  verb.add_option_function<std::vector<std::string>>(
      "--importance",
      [&look](const std::vector<std::string>& rules) {
        look.importance.clear();
        for (const std::string& text : rules) {
          const auto rule = importance_rule(text);
          if (!rule) throw CLI::ValidationError(rule.error().message);
          look.importance.push_back(*rule);
        }
      },
      "[COMPONENT:]LOW:HIGH=IMPORTANCE of a range of values, 0 to 1; several");
  verb.add_flag("!--no-shading", look.shading, "plain colours");
  verb.add_option("--shading", look.style, "phong or gooch: phong");
  verb.add_option("--emphasis", look.emphasis,
                  "how much only what is important is shaded, 0 to 1: 0");
  verb.add_option("--projection", look.projection, "composite, maximum, minimum or mean")
      ->capture_default_str();
  verb.add_option("--grey-level", look.grey_level_hu,
                  "of the other projections, HU; none: as suits what they show");
  verb.add_option("--grey-width", look.grey_width_hu, "as --grey-level");
  verb.add_option("--plane-opacity", look.plane_opacity, "of the ultrasound picture in the 3D view")
      ->capture_default_str();
  add_cutaway_options(verb, look.cutaway);
}

void add_quality_options(CLI::App& verb, SessionConfig& config) {
  verb.add_option("--classification", config.quality.classification,
                  "of values along a ray: pre-integrated or post-classified")
      ->capture_default_str();
  verb.add_flag("--jitter", config.quality.jitter,
                "rays begin at different parts of a step: noise instead of rings");
  add_retired_option(verb, "--adaptive-error", kNoAdaptiveStep);
  verb.add_option_function<std::vector<std::string>>(
      "--cutaway-mesh",
      [&verb, &config](const std::vector<std::string>& files) {
        for (const std::string& file : files) {
          CutawayObject object;
          object.type = CutawayObject::Type::kMesh;
          object.file = file;
          config.cutaway_objects.push_back(object);
        }
        if (verb.count("--no-cutaway") == 0) config.look.cutaway.enabled = true;
      },
      "surface that is cut free too: .stl, .ply or .vtk in the CT's coordinates; several");
}

void add_window_options(CLI::App& verb, SessionConfig::View& view) {
  verb.add_option(
      "--window-level", view.window_level,
      "grey in the middle of flat pictures of the CT, HU; none: as suits what they show");
  verb.add_option("--window-width", view.window_width,
                  "from their black to their white, HU; none: as suits what they show");
}

}  // namespace nav::app
