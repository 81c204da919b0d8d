// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The verbs of sessions: demo, replay, reconstruct, register, slices.
#include "app/appearance/preset_folder.hpp"
#include "app/options/option_checks.hpp"
#include "app/options/option_parser.hpp"
#include "app/options/overwriting.hpp"
#include "app/options/predicate_needs.hpp"
#include "app/options/session_files.hpp"
#include "app/options/verbs.hpp"
#include "app/verbs/devices.hpp"
#include "app/verbs/live.hpp"
#include "io/transform_file.hpp"
#include "nav/positions.hpp"

namespace nav::app {
namespace {

/// The demo that a configuration describes.
DemoOptions demo_of(const SessionConfig& config, DemoOptions demo,
                    const std::optional<std::string>& json) {
  demo.output = config.output;
  demo.appearance = config.appearance;
  demo.view = config.view;
  demo.quality = config.quality;
  demo.cutaway_objects = config.cutaway_objects;
  demo.json = json;
  return demo;
}

/// Rejects a preset that the command line names while the folder of its file is missing. Without
/// the option another one is drawn, with a warning.
Result<void> reject_missing_preset(const CLI::App& verb, const SessionConfig& config) {
  const std::filesystem::path folder = preset_folder();
  std::error_code none;
  const bool named = verb.count("--transfer-function") > 0;
  if (!named || config.appearance.preset != kContextualPreset ||
      std::filesystem::is_directory(folder, none)) {
    return {};
  }
  return Error{ErrorCode::kNotFound, "--transfer-function " + config.appearance.preset +
                                         ": expected the folder of the presets, " +
                                         folder.string() +
                                         ", found none (SONDE_APPEARANCES names another folder)"};
}

/// Reads the transform file that declares the placement of the CT, if there is one.
Result<void> read_transform(session::PlacementOptions& placement) {
  if (placement.transform.empty()) return {};
  const std::string file = placement.transform.string();
  const auto matrix = io::read_ct_from_reference(placement.transform);
  if (!matrix) return matrix.error();
  const auto rigid = rigid_from_matrix<frames::Ct, frames::Reference>(*matrix);
  if (!rigid) return Error{rigid.error().code, file + ": Parameters: " + rigid.error().message};
  if (!is_place(rigid->translation_mm())) {
    return Error{ErrorCode::kMalformedData,
                 file + ": Parameters: expected a translation within 1e7 mm, found another"};
  }
  placement.ct_from_reference = *matrix;
  return {};
}

/// The devices of a session file are for 'sonde live' only.
Error not_live(const std::string& verb) {
  return {ErrorCode::kUsage, verb + ": expected source.kind = \"recording\", found \"live\": " +
                                 "start it by 'sonde live'"};
}

/// Checks the file that gets the kinematics of an emulated arm.
Result<void> check_arm_file(const Settings& settings) {
  const NamedFile arm{"--arm", settings.serve.arm};
  if (settings.serve.emulated != "can-arm") return {};
  if (arm.path.empty()) return Error{ErrorCode::kUsage, "emulate can-arm requires --arm"};
  std::vector<NamedFile> others = session_inputs(settings.config);
  others.push_back({"--session", settings.config.file});
  others.push_back({"--json", settings.json});
  if (auto ok = reject_overwriting({arm}, others); !ok) return ok;
  return reject_unwritable({arm});
}

}  // namespace

CLI::App& CommandLine::add_verb(const char* name, Settings& settings) {
  CLI::App* verb = app_.add_subcommand(name, find_verb(name)->summary);
  add_options(*verb, name, settings);
  return *verb;
}

void CommandLine::add_demo() {
  CLI::App& verb = add_verb("demo", demo_settings_);
  verb.callback([this, &verb] {
    verb_ = [this, &verb](Console& console) -> Result<void> {
      const Settings& given = demo_settings_;
      if (auto ok = as_given(verb, "demo", validate(given.config)); !ok) return ok;
      if (auto ok = reject_idle(verb, "demo", given); !ok) return ok;
      if (auto ok = reject_missing_preset(verb, given.config); !ok) return ok;
      if (auto ok = reject_overwriting_of(given.config, given.json, demo_outputs()); !ok) return ok;
      const DemoOptions demo = demo_of(given.config, given.demo, json_of(given));
      return as_given(verb, "demo", run_demo(demo, console));
    };
  });
}

void CommandLine::add_replay() {
  CLI::App& verb = add_verb("replay", settings_);
  verb.callback([this, &verb] {
    verb_ = [this, &verb](Console& console) -> Result<void> {
      const SessionConfig& config = settings_.config;
      if (auto ok = read_transform(settings_.config.placement); !ok) return ok;
      if (auto ok = as_given(verb, "replay", validate(config)); !ok) return ok;
      if (auto ok = reject_idle(verb, "replay", settings_); !ok) return ok;
      if (auto ok = reject_missing_preset(verb, config); !ok) return ok;
      if (!config.predicates.volume.empty()) {
        if (auto ok = reject_idle_of_set(verb, config.predicates); !ok) return ok;
      }
      if (config.source.kind == SessionConfig::SourceKind::kLive) return not_live("replay");
      const bool simulated = config.source.kind == SessionConfig::SourceKind::kSimulated;
      const auto names = simulated ? demo_outputs() : replay_outputs();
      if (auto ok = reject_overwriting_of(config, settings_.json, names); !ok) return ok;
      if (settings_.print_session) return print_session(config);
      if (simulated) {
        DemoOptions demo = demo_of(config, settings_.demo, json());
        demo.seed = config.source.seed;
        return as_given(verb, "replay", run_demo(demo, console));
      }
      return as_given(verb, "replay", run_replay(config, json(), console));
    };
  });
}

/// Rejects a session that has no devices.
Result<void> CommandLine::check_live(const std::string& verb) const {
  const SessionConfig& config = settings_.config;
  if (config.source.kind == SessionConfig::SourceKind::kLive) return {};
  return Error{ErrorCode::kUsage,
               verb + ": expected --session FILE with source.kind = \"live\", found " +
                   (config.file.empty() ? std::string("no session file")
                                        : "another kind in " + config.file.string())};
}

void CommandLine::add_record() {
  CLI::App& verb = add_verb("record", settings_);
  verb.callback([this, &verb] {
    verb_ = [this, &verb](Console& console) -> Result<void> {
      if (auto ok = as_given(verb, "record", validate(settings_.config)); !ok) return ok;
      if (auto ok = check_live("record"); !ok) return ok;
      if (auto ok = reject_overwriting_of(settings_.config, settings_.json, {}); !ok) return ok;
      return run_session_devices(settings_.config, json(), console);
    };
  });
}

void CommandLine::add_export() {
  CLI::App& verb = add_verb("export", settings_);
  verb.callback([this, &verb] {
    verb_ = [this, &verb](Console& console) -> Result<void> {
      const SessionConfig& config = settings_.config;
      if (auto ok = as_given(verb, "export", validate(config)); !ok) return ok;
      const std::vector<NamedFile> inputs{{"recording", config.source.recording},
                                          {"--config", config.source.plus_config}};
      const std::vector<NamedFile> outputs{{"--out", settings_.exported.out}};
      if (auto ok = reject_overwriting(outputs, inputs); !ok) return ok;
      if (auto ok = reject_unwritable(outputs); !ok) return ok;
      return run_export(config, settings_.exported, console);
    };
  });
}

void CommandLine::add_serve() {
  CLI::App& verb = add_verb("serve", settings_);
  verb.callback([this, &verb] {
    verb_ = [this, &verb](Console& console) -> Result<void> {
      if (auto ok = as_given(verb, "serve", validate(settings_.config)); !ok) return ok;
      if (auto ok = check_live("serve"); !ok) return ok;
      if (auto ok = reject_overwriting_of(settings_.config, settings_.json, {}); !ok) return ok;
      return run_serve(settings_.config, settings_.serve, json(), console);
    };
  });
}

void CommandLine::add_emulate() {
  CLI::App& verb = add_verb("emulate", settings_);
  verb.callback([this, &verb] {
    verb_ = [this, &verb](Console& console) -> Result<void> {
      if (auto ok = as_given(verb, "emulate", validate(settings_.config)); !ok) return ok;
      if (auto ok = reject_idle(verb, "emulate", settings_); !ok) return ok;
      if (auto ok = check_live("emulate"); !ok) return ok;
      if (auto ok = reject_overwriting_of(settings_.config, settings_.json, {}); !ok) return ok;
      if (auto ok = check_arm_file(settings_); !ok) return ok;
      return run_emulate(settings_.config, settings_.serve, json(), console);
    };
  });
}

void CommandLine::add_live() {
  CLI::App& verb = add_verb("live", settings_);
  verb.callback([this, &verb] {
    verb_ = [this, &verb](Console& console) -> Result<void> {
      const SessionConfig& config = settings_.config;
      if (auto ok = read_transform(settings_.config.placement); !ok) return ok;
      if (auto ok = as_given(verb, "live", validate(config)); !ok) return ok;
      if (auto ok = reject_idle(verb, "live", settings_); !ok) return ok;
      if (auto ok = reject_missing_preset(verb, config); !ok) return ok;
      if (auto ok = check_live("live"); !ok) return ok;
      if (auto ok = reject_overwriting_of(config, settings_.json, live_outputs()); !ok) return ok;
      if (settings_.print_session) return print_session(config);
      return as_given(verb, "live", run_live(config, json(), console));
    };
  });
}

void CommandLine::add_devices() {
  add_verb("devices", settings_).callback([this] {
    verb_ = [this](Console& console) -> Result<void> {
      const SessionConfig& config = settings_.config;
      if (settings_.session.empty()) return run_devices(json(), console);
      if (auto ok = check_live("devices"); !ok) return ok;
      if (auto ok = reject_overwriting_of(config, settings_.json, {}); !ok) return ok;
      return run_session_devices(config, json(), console);
    };
  });
}

void CommandLine::add_reconstruct() {
  CLI::App& verb = add_verb("reconstruct", settings_);
  verb.callback([this, &verb] {
    verb_ = [this, &verb](Console& console) -> Result<void> {
      const SessionConfig& config = settings_.config;
      if (auto ok = as_given(verb, "reconstruct", validate(config)); !ok) return ok;
      if (auto ok = reject_idle(verb, "reconstruct", settings_); !ok) return ok;
      return run_reconstruct(config, settings_.reconstruct, json(), console);
    };
  });
}

void CommandLine::add_register() {
  CLI::App& verb = add_verb("register", settings_);
  verb.callback([this, &verb] {
    verb_ = [this, &verb](Console& console) -> Result<void> {
      const SessionConfig& config = settings_.config;
      const RegisterOptions& options = settings_.registration;
      if (auto ok = read_transform(settings_.config.placement); !ok) return ok;
      if (auto ok = as_given(verb, "register", validate(config)); !ok) return ok;
      if (auto ok = reject_idle(verb, "register", settings_); !ok) return ok;
      const std::vector<NamedFile> inputs{{"sweep", config.source.recording},
                                          {"--ct", config.ct.path},
                                          {"--config", config.source.plus_config},
                                          {"--registration", config.placement.registration},
                                          {"--session", config.file},
                                          {"--landmarks", options.landmarks},
                                          {"--ct-landmarks", options.ct_landmarks},
                                          {"--ct-from-reference", config.placement.transform},
                                          {"--points", options.shape.points},
                                          {"--surface", options.shape.surface},
                                          {"--centre-lines", options.shape.centre_lines}};
      const NamedFile transform{"--save-transform", options.save_transform};
      if (auto ok = reject_overwriting({{"--json", settings_.json}, transform}, inputs); !ok) {
        return ok;
      }
      if (auto ok = reject_unwritable({transform}); !ok) return ok;
      const auto outputs = files_in(config.output.folder, register_outputs());
      if (auto ok = reject_overwriting(outputs, inputs); !ok) return ok;
      if (auto ok = reject_report_over(settings_.json, config.output.folder, outputs); !ok) {
        return ok;
      }
      return run_register(config, options, json(), console);
    };
  });
}

void CommandLine::add_slices() {
  CLI::App& verb = add_verb("slices", settings_);
  verb.callback([this, &verb] {
    verb_ = [this, &verb](Console& console) -> Result<void> {
      SessionConfig& config = settings_.config;
      if (auto ok = read_transform(settings_.config.placement); !ok) return ok;
      if (auto ok = as_given(verb, "slices", validate(config)); !ok) return ok;
      if (config.source.kind == SessionConfig::SourceKind::kLive) return not_live("slices");
      // One thing is drawn over a CT: the option wins over the recording of a session file.
      if (!settings_.slices.second.empty()) config.source.recording.clear();
      if (auto ok = reject_idle(verb, "slices", settings_); !ok) return ok;
      return settings_.print_session ? print_session(config)
                                     : run_slices(config, settings_.slices, console);
    };
  });
}

}  // namespace nav::app
