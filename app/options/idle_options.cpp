// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/idle_options.hpp"

#include <algorithm>
#include <initializer_list>
#include <set>
#include <string_view>

#include "app/options/option_needs.hpp"
#include "app/predicates/predicate_volume.hpp"
#include "app/views/panels.hpp"
#include "render/features/derived_features.hpp"
#include "render/predicates/registry.hpp"

namespace nav::app {
namespace {

/// Of `demo` and `replay`.
struct Shown {
  bool without_ct;  ///< Ultrasound is drawn instead of the CT.
  bool needle;
  bool targets;
};

std::vector<Need> needs_of_look(const CLI::App& verb, const SessionConfig& config,
                                const Shown& shown) {
  const SessionConfig::Look& look = config.look;
  const bool composite = look.projection == "composite";
  const std::vector<const char*> cutaway{"--cutaway-inner", "--cutaway-outer", "--cutaway-overlay",
                                         "--cutaway-around", "--cutaway-mesh"};
  const std::vector<const char*> surface{"--shading", "--emphasis"};
  const std::vector<const char*> off{"--no-shading", "--no-cutaway"};
  // By predicates alone colours are the histogram's, and nothing is shaded.
  const std::vector<const char*> of_ct{"--transfer-function", "--importance", "--save-look",
                                       "--shading",           "--emphasis",   "--no-shading"};
  const std::vector<const char*> colours{"--transfer-function", "--look", "--importance",
                                         "--save-look", "--classification"};
  const std::string colourful = "--projection composite";
  return {
      {{"--grey-level", "--grey-width"},
       !composite,
       "--projection maximum, minimum or mean",
       look.projection},
      {colours, composite, colourful, look.projection},
      {surface, composite, colourful, look.projection},
      {cutaway, composite, colourful, look.projection},
      {off, composite, colourful, look.projection},
      {of_ct, !shown.without_ct, "a CT, which they show,", "--us-alone"},
      {surface, look.shading, "shading that is on", "it off"},
      {cutaway, look.cutaway.enabled.value_or(true), "a cutaway that is on", "it off"},
      {{"--cutaway-around"},
       shown.needle || !look.cutaway.around_needle.value_or(false),
       "--needle-frame, the needle that it names,"},
      {{"--cutaway-around"},
       shown.targets || !look.cutaway.around_targets.value_or(false),
       "a session file with a plan, whose targets it names,"},
      {{"--classification"}, !shown.without_ct, "a CT, whose values they sample,", "--us-alone"},
      {{"--pixel-error"},
       config.output.engine != "reference",
       "--engine cpu or gl, which may spare rays,",
       config.output.engine},
      {{"--rms-error"},
       !is_given(verb, "--pixel-error"),
       "no --pixel-error, which it would choose,",
       "both"},
      {{"--rms-error"}, !shown.without_ct, "a CT, whose step it chooses,", "--us-alone"}};
}

Need folder_of_series(const SessionConfig& config) {
  std::error_code ignored;
  return {{"--series"},
          !std::filesystem::is_regular_file(config.ct.path, ignored),
          "a DICOM folder",
          config.ct.path.string()};
}

Need fan_of_face(const PredicateOptions& options) {
  return {{"--face-radius-mm"}, options.apex_ct.has_value(), "--apex"};
}

/// Options of what only some predicates read.
Result<void> refuse_idle_of_set_up(const CLI::App& verb, const PredicateOptions& options) {
  const std::vector<const char*> scan{"--into", "--face", "--apex", "--face-radius-mm",
                                      "--scan-lines"};
  const std::vector<const char*> labels{"--labels", "--layers"};
  const std::vector<const char*> vessels{"--smallest-radius", "--largest-radius", "--bright"};
  const auto given = [&](const auto& names) {
    return std::ranges::any_of(names, [&](const char* name) { return is_given(verb, name); });
  };
  const bool asks = given(scan) || given(labels) || given(vessels) ||
                    given(std::vector<const char*>{"--smoothing-mm", "--cache"});
  if (!asks) return {};
  const auto file = set_up_of(options);
  if (!file) return file.error();
  const std::set<std::string> kinds = render::kinds_of(file->model);
  const std::string found = "none in " + file->name;
  bool reads_scan = false;
  bool reads_labels = false;
  bool reads_vesselness = false;
  bool gradients = false;
  bool derived = false;
  for (const std::string& name : kinds) {
    const auto kind = render::find_predicate_kind(name);
    if (!kind) return kind.error();
    const render::PredicateNeeds needs = (*kind)->needs({});
    reads_scan = reads_scan || render::reads_scan_lines(needs);
    reads_labels = reads_labels || needs.labels;
    for (const std::string& channel : needs.channels) {
      const render::ChannelSource source = render::source_of_channel(channel);
      reads_vesselness = reads_vesselness || channel == render::feature::kVesselness;
      gradients = gradients || source.gradient;
      derived = derived || source.derived;
    }
  }
  return refuse_idle(
      verb,
      {{scan, reads_scan, "a predicate depth, gradient_angle or confidence", found},
       {labels, reads_labels, "a predicate label", found},
       {vessels, reads_vesselness, "a predicate vesselness", found},
       {{"--smoothing-mm"}, gradients, "a predicate gradient_magnitude or gradient_angle", found},
       {{"--cache"}, derived, "a predicate of a derived feature", found}});
}

}  // namespace

Result<void> refuse_idle_of_demo(const CLI::App& verb, const SessionConfig& config) {
  return refuse_idle(verb, needs_of_look(verb, config, {false, true, true}));
}

Result<void> refuse_idle_of_replay(const CLI::App& verb, const SessionConfig& config) {
  const PredicateOptions& predicates = config.predicates;
  const bool ultrasound = !predicates.volume.empty();
  const bool without_ct = ultrasound && predicates.alone;
  const std::vector<const char*> of_volume{"--us-alone",
                                           "--ct-importance",
                                           "--predicates",
                                           "--labels",
                                           "--layers",
                                           "--black",
                                           "--white",
                                           "--into",
                                           "--face",
                                           "--apex",
                                           "--face-radius-mm",
                                           "--scan-lines",
                                           "--cache",
                                           "--unknown",
                                           "--predicate-importance",
                                           "--predicate-colour",
                                           "--opacity-length-mm",
                                           "--smoothing-mm",
                                           "--smallest-radius",
                                           "--largest-radius",
                                           "--bright",
                                           "--hue-mean"};
  std::vector<const char*> of_recording{"sweep",
                                        "--ct",
                                        "--series",
                                        "--accept-unknown-orientation",
                                        "--config",
                                        "--image-frame",
                                        "--probe-frame",
                                        "--tracker-frame",
                                        "--reference-frame",
                                        "--needle-frame",
                                        "--needle-length-mm",
                                        "--needle-diameter-mm",
                                        "--temporal-offset-ms",
                                        "--skip-bad-frames",
                                        "--ct-from-reference",
                                        "--registration",
                                        "--us-volume"};
  of_recording.insert(of_recording.end(), of_volume.begin(), of_volume.end());
  of_recording.insert(of_recording.end(), {"--whole-picture", "--window"});
  std::vector<Need> needs{
      {of_recording, config.source.kind == SessionConfig::SourceKind::kRecording,
       "a session of a recording", "one of the simulated procedure"},
      folder_of_series(config),
      {of_volume, ultrasound, "--us-volume"},
      {{"--frames"},
       !config.output.window || !config.output.folder.empty(),
       "--out, whose pictures it counts,",
       "--window alone"},
      {{"--needle-length-mm", "--needle-diameter-mm"},
       !config.source.needle_frame.empty(),
       "--needle-frame, the needle that it is of,"},
      {{"--ct-importance"}, !without_ct, "a CT, which --us-alone leaves out,", "both"},
      {{"--pixel-error"}, !ultrasound, "a CT alone, whose rays may be spared,", "--us-volume"},
      fan_of_face(predicates),
      {{"--window-level", "--window-width"},
       config.source.kind == SessionConfig::SourceKind::kSimulated ||
           has_panels(config.output.width, config.output.height),
       "a 3D view that has room for the CT's panel",
       std::to_string(config.output.width) + " x " + std::to_string(config.output.height)},
      {{"--us-volume"},
       predicates.alone || config.look.projection == "composite",
       "--us-alone or --projection composite",
       config.look.projection}};
  const bool simulated = config.source.kind == SessionConfig::SourceKind::kSimulated;
  const Shown shown{without_ct, simulated || !config.source.needle_frame.empty(),
                    simulated || config.plan.has_value()};
  for (Need& need : needs_of_look(verb, config, shown)) needs.push_back(std::move(need));
  if (const auto ok = refuse_idle(verb, needs); !ok) return ok;
  return ultrasound ? refuse_idle_of_set_up(verb, predicates) : Result<void>();
}

Result<void> refuse_idle_of_register(const CLI::App& verb, const SessionConfig& config,
                                     const RegisterOptions& options) {
  return refuse_idle(
      verb,
      {{{"--series", "--accept-unknown-orientation"}, !config.ct.path.empty(), "--ct"},
       folder_of_series(config),
       {{"--config", "--image-frame", "--probe-frame", "--tracker-frame", "--needle-frame",
         "--temporal-offset-ms", "--skip-bad-frames", "--effort", "--time-limit", "--loss",
         "--stretch", "--calibration-sigma-mm", "--threads", "--window-level", "--window-width"},
        !config.source.recording.empty(),
        "a sweep"},
       {{"--window-level", "--window-width"}, !config.output.folder.empty(), "--out"},
       {{"--ct-from-reference"},
        options.landmarks.empty(),
        "no --landmarks, which are the start,",
        "both"}});
}

Result<void> refuse_idle_of_predicates(const CLI::App& verb, const PredicateOptions& options) {
  const auto ok = refuse_idle(verb, {{{"--phantom", "--phantom-side"},
                                      options.volume.empty(),
                                      "no volume, which is drawn instead,",
                                      options.volume.string()},
                                     {{"--scribble-share"},
                                      !options.scribbles.empty() || !options.strokes.empty(),
                                      "--scribbles, --show or --hide"},
                                     fan_of_face(options)});
  if (!ok) return ok;
  return refuse_idle_of_set_up(verb, options);
}

Result<void> refuse_idle_of_slices(const CLI::App& verb, const SessionConfig& config,
                                   const SlicesOptions& options) {
  const bool fused = !config.source.recording.empty() || !options.second.empty();
  return refuse_idle(
      verb,
      {{{"--mode"}, options.slab_mm > 0, "--slab", "thin slices"},
       {{"--right"}, options.down_ct.has_value(), "--down"},
       {{"--down"}, options.right_ct.has_value(), "--right"},
       folder_of_series(config),
       {{"--frame", "--whole-picture", "--config", "--image-frame", "--probe-frame",
         "--tracker-frame", "--reference-frame", "--needle-frame", "--temporal-offset-ms",
         "--skip-bad-frames", "--ct-from-reference", "--registration"},
        !config.source.recording.empty(),
        "--recording"},
       {{"--second-level", "--second-width"}, !options.second.empty(), "--second"},
       {{"--fusion", "--share", "--square-mm", "--wipe"}, fused, "--recording or --second"},
       {{"--share"}, options.fusion == "blend", "--fusion blend", options.fusion},
       {{"--square-mm"}, options.fusion == "checkerboard", "--fusion checkerboard", options.fusion},
       {{"--wipe"}, options.fusion == "wipe", "--fusion wipe", options.fusion}});
}

Result<void> refuse_idle_of_derive(const CLI::App& verb, const DeriveOptions& options) {
  const auto any_of = [&](std::initializer_list<std::string_view> names) {
    return options.features.empty() ||
           std::ranges::any_of(options.features, [&](const std::string& feature) {
             return std::ranges::find(names, feature) != names.end();
           });
  };
  return refuse_idle(
      verb,
      {{{"--smallest-radius", "--largest-radius", "--bright"},
        any_of({"vesselness"}),
        "--feature vesselness",
        "others"},
       {{"--into", "--apex", "--face", "--face-radius-mm", "--scan-lines"},
        any_of({"confidence", "gradient-angle", "gradient-along", "gradient-across", "depth"}),
        "--feature confidence, gradient-angle, -along, -across or depth",
        "others"},
       {{"--face-radius-mm"}, !options.apex_mm.empty(), "--apex"},
       {{"--face"}, !options.into.empty(), "--into, parallel scan lines,", "none"},
       {{"--smoothing-mm", "--white"},
        any_of({"gradient-magnitude", "gradient-angle", "gradient-along", "gradient-across"}),
        "--feature gradient-magnitude, -angle, -along or -across",
        "others"},
       {{"--black"},
        any_of(
            {"snr", "gradient-magnitude", "gradient-angle", "gradient-along", "gradient-across"}),
        "--feature snr, gradient-magnitude, -angle, -along or -across",
        "others"},
       {{"--snr-window", "--snr-gaussian"}, any_of({"snr"}), "--feature snr", "others"},
       {{"--confidence-alpha", "--confidence-beta", "--confidence-gamma"},
        any_of({"confidence"}),
        "--feature confidence",
        "others"},
       {{"--unknown"},
        any_of({"snr", "vesselness", "confidence", "gradient-magnitude", "gradient-angle",
                "gradient-along", "gradient-across"}),
        "a --feature of what the voxels hold",
        "depth"}});
}

Result<void> refuse_idle_of_simulate(const CLI::App& verb, const SimulateOptions& o) {
  return refuse_idle(
      verb,
      {{{"--look-at"}, !o.patient_ct.empty(), "--patient-ct"},
       {{"--family", "--contrast"},
        o.patient_ct.empty(),
        "no --patient-ct, of which the patient is made,",
        "both"},
       {{"--ct-spacing-mm", "--contrast"}, !o.ct.empty(), "--ct"},
       {{"--needle-bending-mm", "--needle-bevel-deg", "--needle-speed-mm-s", "--needle-length-mm"},
        o.needle != "none",
        "--needle straight, bevel or tip-load"},
       {{"--needle-bevel-deg"},
        o.needle != "straight",
        "--needle bevel or tip-load, which bend,",
        o.needle},
       {{"--length-mm"},
        o.path != "fan" && o.path != "rock",
        "--path sweep or tilt, which slide,",
        o.path},
       {{"--angle-deg"}, o.path != "sweep", "--path fan, rock or tilt, which swing,", o.path}});
}

}  // namespace nav::app
