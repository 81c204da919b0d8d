// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The verbs of sessions: demo, replay, register, slices.
#include <cmath>
#include <locale>
#include <sstream>

#include "app/options/idle_options.hpp"
#include "app/options/look_options.hpp"
#include "app/options/option_checks.hpp"
#include "app/options/option_keys.hpp"
#include "app/options/overwriting.hpp"
#include "app/options/predicate_command.hpp"
#include "app/options/retired.hpp"
#include "app/options/session_files.hpp"
#include "app/options/slices_options.hpp"
#include "app/options/verbs.hpp"

namespace nav::app {
namespace {

std::string default_of(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// Options that several verbs share, bound to one configuration.
void add_output_options(CLI::App& verb, SessionConfig& config) {
  auto& out = config.output;
  verb.add_option("--engine", out.engine, "cpu, gl or reference")->capture_default_str();
  verb.add_option("--threads", out.threads, "threads of the engine; 0: all cores")
      ->capture_default_str();
  verb.add_option("--width", out.width, "width of the 3D view, pixels")->capture_default_str();
  verb.add_option("--height", out.height, "height of the 3D view, pixels")->capture_default_str();
  auto* step = verb.add_option("--step", out.step_voxels,
                               "sampling distance, voxels; not given: what --rms-error needs");
  verb.add_option_function<double>(
          "--rms-error",
          [&out](const double& rms) {
            out.rms_error = rms;
            out.step_voxels.reset();  // A session's, which an option replaces.
          },
          "root mean square error of the picture's colours that the step is chosen for")
      ->check(in_range(1e-5, 1))
      ->excludes(step)
      ->default_str(default_of(out.rms_error));
  verb.add_option("--pixel-error", out.pixel_error,
                  "pixels between rays that differ by no more have none of their own; 0: all have")
      ->check(in_range(0, 1))
      ->capture_default_str();
  verb.add_option("--azimuth", config.view.azimuth_deg,
                  "of the camera, degrees: 0 from the front, 90 from the patient's left; neither "
                  "angle given: so that the plane is well seen");
  verb.add_option("--elevation", config.view.elevation_deg, "of the camera, degrees from above");
  verb.add_option("--distance", config.view.distance_mm,
                  "of the camera, mm; 0: so that the CT about fills the view, or, nearer, the "
                  "plane does with its surroundings")
      ->capture_default_str();
  verb.add_option("--fov", config.view.fov_deg, "field of view from top to bottom, degrees")
      ->capture_default_str();
  verb.add_flag("--orthographic", config.view.orthographic,
                "parallel rays: what is farther away is no smaller");
  add_window_options(verb, config.view);
}

void add_series_options(CLI::App& verb, SessionConfig& config) {
  verb.add_option("--series", config.ct.series_uid, "SeriesInstanceUID in a DICOM folder");
  verb.add_flag("--accept-unknown-orientation", config.ct.accept_unknown_orientation,
                "take a CT without orientation as LPS");
}

void add_recording_options(CLI::App& verb, SessionConfig& config, std::string& matrix) {
  verb.add_option("--config", config.source.plus_config,
                  "PLUS configuration with the probe's calibration");
  verb.add_option("--image-frame", config.source.image_frame)->capture_default_str();
  verb.add_option("--probe-frame", config.source.probe_frame)->capture_default_str();
  verb.add_option("--tracker-frame", config.source.tracker_frame)->capture_default_str();
  verb.add_option("--reference-frame", config.source.reference_frame,
                  "patient-fixed frame; the tracker frame's name declares the tracker to be it");
  verb.add_option(
      "--needle-frame", config.source.needle_frame,
      "the needle's tip, +z from the hub to it, as NeedleTip; none: no needle is drawn");
  verb.add_option("--temporal-offset-ms", config.source.temporal_offset_ms,
                  "picture stamps minus pose stamps")
      ->capture_default_str();
  verb.add_flag("--skip-bad-frames", config.source.skip_bad_frames,
                "play on past frames whose data cannot be true; they are counted by cause");
  verb.add_option("--ct-from-reference", matrix,
                  "declared placement of the CT: 16 numbers, row-major, mm");
}

void add_source_options(CLI::App& verb, SessionConfig& config, std::string& matrix) {
  verb.add_option("--ct", config.ct.path, "CT: DICOM folder, NIfTI, MetaImage or NRRD");
  add_series_options(verb, config);
  add_recording_options(verb, config, matrix);
}

/// from_option: the registration was named on the command line too.
Result<void> apply_matrix(const std::string& text, bool from_option, SessionConfig& config) {
  if (text.empty()) {
    if (from_option) config.placement.ct_from_reference.reset();
    return {};
  }
  if (from_option) {
    return Error{ErrorCode::kUsage,
                 "--ct-from-reference: expected it or --registration, found both"};
  }
  config.placement.registration.clear();
  std::string spaced = text;
  for (char& c : spaced) c = c == ',' ? ' ' : c;
  std::istringstream stream(spaced);
  stream.imbue(std::locale::classic());
  std::vector<double> numbers;
  for (double number = 0; stream >> number;) numbers.push_back(number);
  if (numbers.size() != 16 || !stream.eof()) {
    return Error{ErrorCode::kUsage,
                 "--ct-from-reference: expected 16 numbers, found '" + text + "'"};
  }
  config.placement.ct_from_reference =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  return {};
}

Result<void> validate_start(const DemoOptions& demo) {
  const auto refuse = [](const std::string& option, const std::string& most, double found) {
    return Error{ErrorCode::kUsage,
                 option + ": expected 0 to " + most + ", found " + std::to_string(found)};
  };
  if (!(demo.start_error_mm >= 0 && demo.start_error_mm <= 1000)) {
    return refuse("--start-error-mm", "1000", demo.start_error_mm);
  }
  if (!(demo.start_error_deg >= 0 && demo.start_error_deg <= 180)) {
    return refuse("--start-error-deg", "180", demo.start_error_deg);
  }
  return {};
}

}  // namespace

void CommandLine::add_demo() {
  CLI::App* demo = app_.add_subcommand(
      "demo",
      "Simulated procedure: sweep, registration, needle approach with the live plane in CT");
  SessionConfig& config = demo_config_;
  config.look = demo_.look;
  config.view = demo_.view;
  demo->add_option("--out", config.output.folder, "folder to write to")->required();
  add_output_options(*demo, config);
  add_look_options(*demo, config.look);
  add_quality_options(*demo, config);
  demo->add_option("--seed", demo_.seed, "which simulated patient")
      ->check(whole_number())
      ->capture_default_str();
  demo->add_option("--frames", config.output.frames,
                   "pictures of the needle approach; 0: the default of 30")
      ->capture_default_str();
  demo->add_option("--start-error-mm", demo_.start_error_mm)->capture_default_str();
  demo->add_option("--start-error-deg", demo_.start_error_deg)->capture_default_str();
  add_json(*demo);
  demo->callback([this, demo] {
    verb_ = [this, demo](Console& console) -> Result<void> {
      if (const auto ok = as_given(*demo, validate(demo_config_)); !ok) return ok;
      if (const auto ok = refuse_idle_of_demo(*demo, demo_config_); !ok) return ok;
      if (const auto ok = validate_start(demo_); !ok) return ok;
      if (const auto own = refuse_overwriting_of(demo_config_, json_, demo_outputs()); !own) {
        return own;
      }
      demo_.output = demo_config_.output;
      demo_.look = demo_config_.look;
      demo_.view = demo_config_.view;
      demo_.quality = demo_config_.quality;
      demo_.cutaway_objects = demo_config_.cutaway_objects;
      demo_.json = json();
      return as_given(*demo, run_demo(demo_, console));
    };
  });
}

void CommandLine::add_replay() {
  CLI::App* replay =
      app_.add_subcommand("replay", "Replay a recorded PLUS sweep and show its plane in a CT");
  replay->add_option("sweep", config_.source.recording, "PLUS sequence: .igs.mha, .mhd, .nrrd");
  replay->add_option("--session", session_, "session file (TOML); options here win over it");
  add_source_options(*replay, config_, matrix_);
  replay->add_option("--registration", config_.placement.registration,
                     "result of 'sonde register'");
  replay->add_flag("--follow", config_.placement.follow,
                   "from the registration on, the CT follows tissue that moves");
  replay
      ->add_option("--needle-length-mm", config_.source.needle_size.length_mm,
                   "hub to tip, as the needle is drawn")
      ->capture_default_str();
  replay
      ->add_option("--needle-diameter-mm", config_.source.needle_size.diameter_mm,
                   "of its shaft, as it is drawn and as distances from its surface count")
      ->capture_default_str();
  replay->add_option("--out", config_.output.folder, "folder to write to");
  add_output_options(*replay, config_);
  add_look_options(*replay, config_.look);
  add_quality_options(*replay, config_);
  replay->add_option("--us-volume", config_.predicates.volume,
                     "3D ultrasound in the CT's frame, drawn by predicates inside the CT");
  replay->add_flag("--us-alone", config_.predicates.alone, "--us-volume instead of the CT");
  replay
      ->add_option("--ct-importance", config_.predicates.ct_importance,
                   "what the CT counts beside --us-volume; 1: as a predicate of average "
                   "importance; 0: all ultrasound shines through")
      ->capture_default_str();
  replay->add_option("--predicates", config_.predicates.set_up,
                     "how --us-volume is drawn: a preset, or a file");
  add_ultrasound_options(*replay, config_.predicates);
  add_set_up_edits(*replay, config_.predicates, "--predicate-importance", "--predicate-colour");
  replay->add_option("--frames", config_.output.frames, "most pictures to write; 0: all")
      ->capture_default_str();
  replay->add_flag("--whole-picture", config_.source.whole_picture,
                   "also draw what lies around the sector that the pictures show");
  replay->add_flag("--window", config_.output.window,
                   "play it in a window at its own pace; pictures are written only to --out");
  replay->add_flag("--print-session", print_session_, "print the resolved session file and stop");
  add_json(*replay);
  replay->callback([this, replay] {
    verb_ = [this, replay](Console& console) -> Result<void> {
      const bool registered = replay->count("--registration") > 0;
      if (const auto ok = apply_matrix(matrix_, registered, config_); !ok) return ok;
      if (const auto ok = as_given(*replay, validate(config_)); !ok) return ok;
      if (const auto ok = refuse_idle_of_replay(*replay, config_); !ok) return ok;
      const bool simulated = config_.source.kind == SessionConfig::SourceKind::kSimulated;
      const auto names = simulated ? demo_outputs() : replay_outputs();
      if (const auto own = refuse_overwriting_of(config_, json_, names); !own) return own;
      if (print_session_) return print_session(config_);
      if (simulated) {
        demo_.seed = config_.source.seed;
        demo_.output = config_.output;
        demo_.look = config_.look;
        demo_.view = config_.view;
        demo_.quality = config_.quality;
        demo_.cutaway_objects = config_.cutaway_objects;
        demo_.json = json();
        return as_given(*replay, run_demo(demo_, console));
      }
      return as_given(*replay, run_replay(config_, json(), console));
    };
  });
}

void CommandLine::add_register() {
  CLI::App* verb =
      app_.add_subcommand("register", "Register a CT to a recorded sweep, or by landmarks");
  verb->add_option("sweep", config_.source.recording, "PLUS sequence; none: landmarks alone");
  add_source_options(*verb, config_, matrix_);
  verb->add_option("--landmarks", register_.landmarks,
                   "comma-separated pairs; the start pose, or the whole registration");
  verb->add_option("--marker-towards", register_.marker_towards,
                   "without a start pose: where the left edge of the pictures points in the "
                   "patient: right, left, anterior, posterior, superior or inferior");
  verb->add_option("--effort", register_.effort,
                   "quick: in a fifth of the time, a few tenths of a millimetre farther off; usual")
      ->capture_default_str();
  verb->add_option(
      "--time-limit", register_.time_limit_s,
      "s, also of the search without a start pose: the best pose until then is reported "
      "and refused; none until then is a refusal");
  add_retired_option(*verb, "--similarity", "a sweep and a CT are compared by LC2");
  verb->add_option("--loss", register_.loss,
                   "how little a patch counts that the CT explains badly: none, cauchy or "
                   "geman-mcclure")
      ->capture_default_str();
  verb->add_option("--stretch", register_.stretch,
                   "refined beside the pose: none, sound-speed or affine")
      ->capture_default_str();
  verb->add_option("--calibration-sigma-mm", register_.calibration_sigma_mm,
                   "how well the probe's calibration is known, 0 to 10: the part of it that the "
                   "pose takes up is predicted with the rest")
      ->check(in_range(0, 10, "mm"))
      ->capture_default_str();
  verb->add_option(
      "--breath-period", register_.motion.breath_period_s,
      "s, 1 to 20: a pose for each phase of the breath, where the pictures support it");
  verb->add_flag("--deformable", register_.motion.deformable,
                 "a smooth displacement of the tissue, where the pictures support it");
  verb->add_option("--points", register_.shape.points,
                   "tracked points on a surface or along vessels, three numbers in each line");
  verb->add_option("--surface", register_.shape.surface,
                   "what they touched: .vtk, .stl or .ply in the CT's coordinates");
  verb->add_option("--centre-lines", register_.shape.centre_lines,
                   "what they ran along: points in the CT, an empty line between branches");
  verb->add_option("--target", target_, "x y z in the CT, LPS mm: where the error is judged")
      ->expected(3);
  verb->add_option("--threads", config_.output.threads)->capture_default_str();
  verb->add_option("--out", config_.output.folder, "folder for pictures and report");
  add_window_options(*verb, config_.view);
  add_json(*verb);
  verb->callback([this, verb] {
    verb_ = [this, verb](Console& console) -> Result<void> {
      if (const auto ok = apply_matrix(matrix_, false, config_); !ok) return ok;
      if (const auto ok = as_given(*verb, validate(config_)); !ok) return ok;
      if (const auto ok = refuse_idle_of_register(*verb, config_, register_); !ok) return ok;
      if (!target_.empty()) {
        for (const double coordinate : target_) {
          if (!std::isfinite(coordinate)) {
            return Error{ErrorCode::kUsage, "--target: expected 3 finite numbers, found " +
                                                std::to_string(coordinate)};
          }
        }
        register_.target_ct = Eigen::Vector3d(target_[0], target_[1], target_[2]);
      }
      const std::vector<NamedFile> inputs{{"sweep", config_.source.recording},
                                          {"--ct", config_.ct.path},
                                          {"--config", config_.source.plus_config},
                                          {"--landmarks", register_.landmarks},
                                          {"--points", register_.shape.points},
                                          {"--surface", register_.shape.surface},
                                          {"--centre-lines", register_.shape.centre_lines}};
      if (const auto ok = refuse_overwriting({{"--json", json_}}, inputs); !ok) return ok;
      const auto outputs = files_in(config_.output.folder, register_outputs());
      if (const auto ok = refuse_overwriting(outputs, inputs); !ok) return ok;
      return run_register(config_, register_, json(), console);
    };
  });
}

void CommandLine::add_slices() {
  CLI::App* verb = app_.add_subcommand(
      "slices", "Write CT slices: axial, coronal, sagittal, oblique, along needle and ultrasound");
  verb->add_option("ct", config_.ct.path, "CT: DICOM folder, NIfTI, MetaImage or NRRD");
  verb->add_option("--session", session_, "session file (TOML); options here win over it");
  verb->add_option("--out", config_.output.folder, "folder to write to");
  add_series_options(*verb, config_);
  verb->add_option("--recording", config_.source.recording,
                   "PLUS sequence: also the slice along a picture of it, laid over the CT");
  verb->add_option("--registration", config_.placement.registration, "result of 'sonde register'");
  add_recording_options(*verb, config_, matrix_);
  add_slices_options(*verb, config_, slices_);
  verb->add_flag("--print-session", print_session_, "print the resolved session file and stop");
  verb->callback([this, verb] {
    verb_ = [this, verb](Console& console) -> Result<void> {
      const bool registered = verb->count("--registration") > 0;
      if (const auto ok = apply_matrix(matrix_, registered, config_); !ok) return ok;
      if (const auto ok = as_given(*verb, validate(config_)); !ok) return ok;
      // One thing is laid over a CT: the option wins over the session's recording.
      if (!slices_.second.empty()) config_.source.recording.clear();
      if (const auto ok = refuse_idle_of_slices(*verb, config_, slices_); !ok) return ok;
      return print_session_ ? print_session(config_) : run_slices(config_, slices_, console);
    };
  });
}

}  // namespace nav::app
