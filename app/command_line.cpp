// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/command_line.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <new>
#include <sstream>

#include "app/bench.hpp"
#include "app/bench_derived.hpp"
#include "app/bench_registration.hpp"
#include "app/demo.hpp"
#include "app/derive.hpp"
#include "app/devices.hpp"
#include "app/exit_code.hpp"
#include "app/gallery.hpp"
#include "app/idle_options.hpp"
#include "app/info.hpp"
#include "app/look_options.hpp"
#include "app/option_checks.hpp"
#include "app/option_keys.hpp"
#include "app/overwriting.hpp"
#include "app/predicate_command.hpp"
#include "app/predicates.hpp"
#include "app/replay.hpp"
#include "app/session_files.hpp"
#include "app/simulate.hpp"
#include "app/slices.hpp"
#include "app/slices_options.hpp"
#include "sim/anatomy/patient.hpp"
#include "sim/session/simulated_session.hpp"

namespace nav::app {
namespace {

using Verb = std::function<Result<void>(Console&)>;

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
  verb.add_option("--distance", config.view.distance_mm, "of the camera, mm; 0: the CT fits")
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

Result<void> print_session(const SessionConfig& config) {
  const auto text = to_toml(config);
  if (!text) return text.error();
  std::cout << *text;
  return {};
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

/// The session file first, then what the command line says on top: parsing twice keeps one list of
/// options.
class CommandLine {
 public:
  CommandLine()
      : app_(
            "Sonde: live ultrasound inside the CT. Research software, not a medical "
            "device.") {
    app_.set_version_flag("--version", "sonde " SONDE_VERSION);
    app_.require_subcommand(1);
    app_.add_flag("-v,--verbose", verbose_, "also show information of the libraries");
    app_.fallthrough();
    add_demo();
    add_replay();
    add_register();
    add_info();
    add_slices();
    add_predicates();
    add_derive();
    add_bench();
    add_gallery();
    add_devices();
    add_simulate();
  }

  int run(int argc, const char* const* argv);

 private:
  void add_demo();
  void add_replay();
  void add_register();
  void add_info();
  void add_slices();
  void add_predicates();
  void add_derive();
  void add_bench();
  void add_bench_registration(CLI::App& bench);
  void add_bench_derived(CLI::App& bench);
  void add_bench_predicates(CLI::App& bench);
  void add_gallery();
  void add_devices();
  void add_simulate();
  void add_json(CLI::App& verb) {
    verb.add_option("--json", json_, "write the report as JSON here too; -: standard output");
  }
  [[nodiscard]] std::optional<std::string> json() const {
    return json_.empty() ? std::nullopt : std::optional(json_);
  }
  int fail(const Error& error) const;

  CLI::App app_;
  bool verbose_ = false;
  std::string json_;
  std::string session_;
  std::string matrix_;
  std::string path_;
  SessionConfig config_;
  SessionConfig demo_config_;
  DemoOptions demo_;
  RegisterOptions register_;
  SlicesOptions slices_;
  DeriveOptions derive_;
  std::vector<double> target_;
  BenchRenderOptions bench_;
  BenchPredicatesOptions predicates_;
  BenchScalingOptions scaling_;
  BenchRegistrationOptions bench_registration_;
  BenchDerivedOptions derived_;
  GalleryOptions gallery_;
  SimulateOptions simulate_;
  bool accept_unknown_orientation_ = false;
  bool print_session_ = false;
  Verb verb_;
};

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
  verb->add_option("--similarity", register_.similarity, "of sweep and CT: lc2, ncc or mi")
      ->capture_default_str();
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

void CommandLine::add_info() {
  CLI::App* info =
      app_.add_subcommand("info", "Say what a file is: sequence, CT or PLUS configuration");
  info->add_option("file", path_, "file, or DICOM folder")->required();
  info->add_flag("--accept-unknown-orientation", accept_unknown_orientation_,
                 "take a CT without orientation as LPS");
  add_json(*info);
  info->callback([this] {
    verb_ = [this](Console& console) -> Result<void> {
      if (auto ok = refuse_overwriting({{"--json", json_}}, {{"file", path_}}); !ok) return ok;
      return run_info(path_, json(), accept_unknown_orientation_, console);
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

void CommandLine::add_predicates() {
  CLI::App* verb = app_.add_subcommand(
      "predicates", "3D ultrasound by predicates beside a standard transfer function, one picture");
  add_predicate_options(*verb, config_);
  verb->add_option("--session", session_, "session file (TOML); options here win over it");
  verb->add_flag("--print-session", print_session_, "print the resolved session file and stop");
  verb->callback([this, verb] {
    verb_ = [this, verb](Console& console) -> Result<void> {
      if (const auto ok = as_given(*verb, validate(config_)); !ok) return ok;
      if (const auto ok = as_given(*verb, refuse_idle_of_predicates(*verb, config_.predicates));
          !ok) {
        return ok;
      }
      if (print_session_) return print_session(config_);
      return as_given(*verb, run_predicates(config_, console));
    };
  });
}

void CommandLine::add_derive() {
  CLI::App* verb = app_.add_subcommand(
      "derive", "Write slices of the features that predicates read from an ultrasound volume");
  DeriveOptions& o = derive_;
  verb->add_option("volume", o.volume, "DICOM folder, NIfTI, MetaImage or NRRD")->required();
  verb->add_option("--out", o.out, "folder to write to")->required();
  verb->add_option(
      "--feature", o.features,
      "snr, vesselness, confidence, gradient-magnitude, gradient-angle, gradient-along, "
      "gradient-across or depth; none: all that can be derived");
  auto* into =
      verb->add_option("--into", o.into, "x y z, LPS: of parallel scan lines, away from the probe")
          ->expected(3);
  verb->add_option("--face", o.face_mm,
                   "x y z, LPS mm: a point of the plane where parallel lines have depth 0; none: "
                   "the known voxel nearest to the probe")
      ->expected(3);
  auto* apex =
      verb->add_option("--apex", o.apex_mm, "x y z, LPS mm: apex of a fan of scan lines instead")
          ->expected(3)
          ->excludes(into);
  verb->add_option("--face-radius-mm", o.face_radius_mm, "of the fan's probe")
      ->check(in_range(0, 1e4, "mm"))
      ->capture_default_str();
  verb->add_option("--scan-lines", o.scan_lines,
                   "file of the planes of the sweep that the volume was made from, instead")
      ->excludes(into)
      ->excludes(apex);
  verb->add_option("--smoothing-mm", o.smoothing_mm, "of gradients")
      ->check(in_range(0, 20, "mm"))
      ->capture_default_str();
  verb->add_option("--black", o.black, "stored value of black")->capture_default_str();
  verb->add_option("--white", o.white, "stored value of white")->capture_default_str();
  verb->add_option("--snr-window", o.snr.window_voxels, "side of the neighbourhood, voxels, odd")
      ->capture_default_str();
  verb->add_flag_function(
      "--snr-gaussian",
      [&o](std::int64_t) { o.snr.weights = render::derived::WindowWeights::kGaussian; },
      "what is farther from the middle counts less");
  verb->add_option("--confidence-alpha", o.confidence.alpha, "attenuation")->capture_default_str();
  verb->add_option("--confidence-beta", o.confidence.beta, "steepness")->capture_default_str();
  verb->add_option("--confidence-gamma", o.confidence.gamma, "penalty across scan lines")
      ->capture_default_str();
  verb->add_option("--smallest-radius", o.smallest_radius_mm, "of vessels, mm")
      ->check(in_range(1e-3, 100, "mm"))
      ->capture_default_str();
  verb->add_option("--largest-radius", o.largest_radius_mm, "of vessels, mm")
      ->check(in_range(1e-3, 100, "mm"))
      ->capture_default_str();
  verb->add_flag("--bright", o.bright_vessels, "vessels are brighter than what surrounds them");
  verb->add_option("--cache", o.cache, "folder that keeps derived features for the next time");
  verb->add_option("--unknown", o.unknown, "value of voxels that no picture reached")
      ->check(in_range(-32768, 32767));
  verb->add_option("--threads", o.threads, "0: all cores")
      ->check(in_range(0, 1024, "threads"))
      ->capture_default_str();
  verb->callback([this, verb] {
    verb_ = [this, verb](Console& console) -> Result<void> {
      if (const auto ok = refuse_idle_of_derive(*verb, derive_); !ok) return ok;
      return run_derive(derive_, console);
    };
  });
}

void CommandLine::add_simulate() {
  CLI::App* verb = app_.add_subcommand(
      "simulate", "Write a recording of a simulated patient, with its truth and its CT");
  SimulateOptions& o = simulate_;
  verb->add_option("--out", o.out, "recording to write, .mha or .nrrd")->required();
  verb->add_option("--truth", o.truth, "truth to write (JSON); none: beside the recording");
  verb->add_option("--ct", o.ct, "CT of the patient to write, .mha");
  verb->add_option("--ct-spacing-mm", o.ct_spacing_mm)->capture_default_str();
  std::vector<std::string> families;
  for (const sim::PatientFamily& family : sim::patient_families()) families.push_back(family.name);
  verb->add_option("--family", o.family, "of patients")
      ->check(among(families))
      ->capture_default_str();
  verb->add_option("--contrast", o.contrast,
                   "of the CT: native, arterial, portal, or mr: grey values like those of MR")
      ->check(taken_by(sim::contrast_from))
      ->capture_default_str();
  verb->add_option("--patient-ct", o.patient_ct,
                   "a recorded CT, file or folder: the patient is made of it");
  verb->add_option("--look-at", o.look_at_mm, "point of that CT, LPS mm");
  verb->add_option("--seed", o.seed, "which patient, room, hand and breath")
      ->check(whole_number())
      ->capture_default_str();
  verb->add_option("--path", o.path, "sweep, fan, rock or tilt")
      ->check(taken_by(sim::hand_path_kind_from))
      ->capture_default_str();
  verb->add_option("--length-mm", o.length_mm, "of the slide; 0: 60 convex, 40 linear, 16 sector")
      ->capture_default_str();
  verb->add_option("--angle-deg", o.angle_deg, "of the swing")->capture_default_str();
  verb->add_option("--probe", o.probe,
                   "standard (the family's own, in its usual view), convex, linear or sector")
      ->check(taken_by(sim::probe_model_from, "standard"))
      ->capture_default_str();
  verb->add_option("--model", o.model, "how echoes are computed: rays or scatterers")
      ->check(taken_by(sim::acoustic_model_from))
      ->capture_default_str();
  verb->add_flag("--mirrored", o.mirrored, "the probe's marker is on the other side");
  verb->add_option("--tracker", o.tracker, "ideal, optical, electromagnetic or arm")
      ->check(taken_by(sim::tracker_kind_from))
      ->capture_default_str();
  verb->add_option("--breathing", o.breathing, "none, rigid, affine or smooth")
      ->check(taken_by(sim::breathing_kind_from))
      ->capture_default_str();
  verb->add_option("--breathing-mm", o.breathing_mm,
                   "mean way towards the feet; none: 12, of a patient who breathes");
  verb->add_option("--breathing-period-s", o.breathing_period_s,
                   "mean time of a breath; none: 4, of a patient who breathes");
  verb->add_option("--deform-mm", o.deform_mm,
                   "largest displacement of a target against the CT, smooth; 0: none")
      ->capture_default_str();
  verb->add_option("--needle", o.needle, "none, straight, bevel or tip-load")
      ->check(taken_by(sim::bending_kind_from, "none"))
      ->capture_default_str();
  verb->add_option("--needle-bending-mm", o.needle_bending_mm,
                   "sideways way of the tip at the target; none: that of a usual needle");
  verb->add_option("--needle-bevel-deg", o.needle_bevel_deg, "direction of the bending");
  verb->add_option("--needle-speed-mm-s", o.needle_speed_mm_s,
                   "0: the target is reached with the last picture");
  verb->add_option("--needle-length-mm", o.needle_length_mm, "hub to tip")->capture_default_str();
  verb->add_option("--faults", o.faults,
                   "chance of each fault at each sample, or of some: drop=0.02,nan=0.001")
      ->capture_default_str();
  verb->add_option("--tracker-rate-hz", o.tracker_rate_hz)->capture_default_str();
  verb->add_option("--latency-ms", o.latency_ms, "of poses")->capture_default_str();
  verb->add_option("--jitter-ms", o.jitter_ms, "of poses, at most")->capture_default_str();
  verb->add_option("--clock-offset-ms", o.clock_offset_ms, "of the tracker")->capture_default_str();
  verb->add_option("--clock-drift-ppm", o.clock_drift_ppm, "of the tracker")->capture_default_str();
  verb->add_option("--loss", o.loss, "chance that a burst of lost poses begins at one")
      ->capture_default_str();
  verb->add_option("--picture-offset-ms", o.picture_offset_ms, "of the pictures' stamps")
      ->capture_default_str();
  verb->add_option("--duration-s", o.duration_s)->capture_default_str();
  verb->add_option("--frame-rate-hz", o.frame_rate_hz)->capture_default_str();
  verb->add_option("--columns", o.columns, "of the pictures; 0: the probe's own");
  verb->add_option("--rows", o.rows, "of the pictures; 0: the probe's own");
  verb->add_flag("--compress", o.compress, "the recording's pixels");
  for (const auto& [option, expected] : simulate_ranges()) {
    verb->get_option(option)->check(number_of(expected));
  }
  verb->callback([this, verb] {
    verb_ = [this, verb](Console& console) {
      if (const auto ok = refuse_idle_of_simulate(*verb, simulate_); !ok) return ok;
      const auto ok = refuse_overwriting(
          {{"--out", simulate_.out}, {"--ct", simulate_.ct}, {"--truth", simulate_.truth}},
          {{"--patient-ct", simulate_.patient_ct}});
      return ok ? run_simulate(simulate_, console) : ok;
    };
  });
}

void CommandLine::add_bench() {
  CLI::App* bench = app_.add_subcommand("bench", "Measure run time against error");
  bench->require_subcommand(1);
  CLI::App* render = bench->add_subcommand(
      "render", "Sonde's engines beside VTK's volume mappers, and their agreement");
  render->add_option("--ct", bench_.ct, "CT to draw instead of the scene set");
  render->add_option("--scene", bench_.scene, "only scenes whose name contains this");
  render->add_option("--part", bench_.parts, "compare, live, skipping; default the first two")
      ->check(among({"compare", "live", "skipping"}))
      ->delimiter(',');
  render->add_flag("--quick", bench_.quick, "few scenes, small pictures: about two minutes");
  render->add_flag("--costs", bench_.costs, "also the cost of every element of a picture");
  render->add_option("--width", bench_.width, "of the timed pictures, pixels")
      ->check(in_range(16, 8192, "pixels"))
      ->capture_default_str();
  render->add_option("--height", bench_.height, "of the timed pictures, pixels")
      ->check(in_range(16, 8192, "pixels"))
      ->capture_default_str();
  add_json(*render);
  render->callback([this, render] {
    verb_ = [this, render](Console& console) -> Result<void> {
      bench_.json = json();
      if (auto ok = refuse_idle_of_bench(*render, bench_); !ok) return ok;
      if (auto ok = refuse_overwriting({{"--json", json_}}, {{"--ct", bench_.ct}}); !ok) return ok;
      return run_bench_render(bench_, console);
    };
  });
  add_bench_predicates(*bench);
  CLI::App* scaling = bench->add_subcommand(
      "scaling", "Time and memory of the CPU engine against size, pixels, threads, occupancy");
  scaling->add_option("--largest", scaling_.largest, "side of the largest volume, voxels")
      ->check(in_range(64, 768, "voxels"))
      ->capture_default_str();
  add_json(*scaling);
  scaling->callback([this] {
    verb_ = [this](Console& console) {
      scaling_.json = json();
      return run_bench_scaling(scaling_, console);
    };
  });
  add_bench_registration(*bench);
  add_bench_derived(*bench);
}

void CommandLine::add_bench_registration(CLI::App& bench) {
  CLI::App* verb = bench.add_subcommand(
      "registration", "Registration on simulated patients: error, success, refusals, time");
  verb->add_flag("--quick", bench_registration_.quick, "part of the cohort: about two minutes");
  verb->add_flag("!--no-evaluation", bench_registration_.evaluate,
                 "leave the evaluation seeds alone: for tuning");
  add_choice<sim::AcousticModel>(
      *verb, "--model", bench_registration_.model,
      {{"rays", sim::AcousticModel::kRays}, {"scatterers", sim::AcousticModel::kScatterers}},
      "how echoes are computed: rays, scatterers");
  add_choice<registration::Effort>(
      *verb, "--effort", bench_registration_.effort,
      {{"quick", registration::Effort::kQuick}, {"usual", registration::Effort::kUsual}},
      "of cohort, faults and starts: quick or usual");
  verb->add_option("--patients", bench_registration_.patients, "of each cohort")
      ->check(in_range(1, 100, "patients"));
  verb->add_option(
          "--part", bench_registration_.parts,
          "cohort, faults, starts, curve, bootstrap, skin, motion, live, peer; default all")
      ->check(among(
          {"cohort", "faults", "starts", "curve", "bootstrap", "skin", "motion", "live", "peer"}))
      ->delimiter(',');
  verb->add_option("--trials", bench_registration_.trials, "CSV with a line per registration");
  add_json(*verb);
  verb->callback([this, verb] {
    verb_ = [this, verb](Console& console) -> Result<void> {
      bench_registration_.json = json();
      if (auto ok = refuse_idle_of_bench(*verb, bench_registration_); !ok) return ok;
      const std::vector<NamedFile> outputs{{"--json", json_},
                                           {"--trials", bench_registration_.trials.value_or("")}};
      if (auto ok = refuse_overwriting(outputs, {}); !ok) return ok;
      return run_bench_registration(bench_registration_, console);
    };
  });
}

void CommandLine::add_bench_predicates(CLI::App& bench) {
  CLI::App* verb = bench.add_subcommand(
      "predicates", "Ultrasound by predicates beside a standard transfer function");
  verb->add_flag("--quick", predicates_.quick, "a small phantom, small pictures: some seconds");
  verb->add_option("--side", predicates_.side, "of the phantom, voxels")
      ->check(in_range(32, 768, "voxels"))
      ->capture_default_str();
  verb->add_option("--width", predicates_.width, "pixels; half of it where OpenGL is software")
      ->check(in_range(32, 4096, "pixels"))
      ->capture_default_str();
  verb->add_option("--height", predicates_.height, "as --width")
      ->check(in_range(32, 4096, "pixels"))
      ->capture_default_str();
  verb->add_option("--volume", predicates_.volume,
                   "only volumes whose name begins so: neck, …, two-volumes, features");
  verb->add_option("--look", predicates_.look,
                   "only set-ups whose name begins so, of a --volume that has some");
  verb->add_option("--engine", predicates_.engine, "cpu, gl or both")
      ->check(among({"cpu", "gl", "both"}))
      ->capture_default_str();
  verb->add_option("--threads", predicates_.threads, "0: all cores")
      ->check(in_range(0, 1024, "threads"))
      ->capture_default_str();
  add_json(*verb);
  verb->callback([this, verb] {
    verb_ = [this, verb](Console& console) {
      predicates_.json = json();
      const auto ok = refuse_idle_of_bench(*verb, predicates_);
      return ok ? run_bench_predicates(predicates_, console) : ok;
    };
  });
}

void CommandLine::add_bench_derived(CLI::App& bench) {
  CLI::App* derived = bench.add_subcommand(
      "derived", "Time, memory and error of the features that predicates read, beside ITK's");
  derived->add_option("--side", derived_.side, "of the timed volume, voxels")
      ->check(in_range(32, 512, "voxels"))
      ->capture_default_str();
  derived->add_option("--threads", derived_.threads, "0: all cores")
      ->check(in_range(0, 1024, "threads"))
      ->capture_default_str();
  derived->add_flag("--quick", derived_.quick, "96 voxels a side, once each: seconds");
  add_json(*derived);
  derived->callback([this, derived] {
    verb_ = [this, derived](Console& console) {
      derived_.json = json();
      const auto ok = refuse_idle_of_bench(*derived, derived_);
      return ok ? run_bench_derived(derived_, console) : ok;
    };
  });
}

void CommandLine::add_gallery() {
  CLI::App* gallery = app_.add_subcommand("gallery", "Draw the pictures of docs/gallery.md");
  gallery->add_option("--out", gallery_.out, "folder to write to")->required();
  gallery->add_option("--engine", gallery_.engine, "cpu, gl or reference")->capture_default_str();
  gallery->add_option("--only", gallery_.only, "only pictures whose name contains this");
  gallery->add_option("--width", gallery_.width)
      ->check(in_range(16, 4096, "pixels"))
      ->capture_default_str();
  gallery->add_option("--height", gallery_.height)
      ->check(in_range(16, 4096, "pixels"))
      ->capture_default_str();
  gallery->callback(
      [this] { verb_ = [this](Console& console) { return run_gallery(gallery_, console); }; });
}

void CommandLine::add_devices() {
  CLI::App* list =
      app_.add_subcommand("devices", "List USB devices, CAN interfaces and simulated devices");
  add_json(*list);
  list->callback(
      [this] { verb_ = [this](Console& console) { return run_devices(json(), console); }; });
}

int CommandLine::fail(const Error& error) const {
  std::fprintf(stderr, "sonde: error: %s\n", without_controls(error.message).c_str());
  return exit_code(error);
}

int CommandLine::run(int argc, const char* const* argv) {
  // The session file is the ground that the options stand on: it must be read before they are.
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    std::string file;
    if (argument == "--session" && i + 1 < argc) file = argv[i + 1];
    if (argument.starts_with("--session=")) file = argument.substr(10);
    if (file.empty()) continue;
    auto config = read_session_config(file);
    if (!config) return fail(config.error());
    config_ = std::move(*config);
  }
  try {
    app_.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    return app_.exit(success);
  } catch (const CLI::ParseError& problem) {
    return fail({ErrorCode::kUsage, in_words(app_, problem)});
  }
  if (const auto ok = refuse_empty(app_); !ok) return fail(ok.error());
  const auto json =
      refuse_unwritable({{"--json", json_}}, {config_.output.folder, demo_.output.folder});
  if (!json) return fail(json.error());
  Console console(verbose_);
  const auto outcome = verb_(console);
  if (outcome) {
    std::cout << std::flush;
    if (!std::cout) return fail({ErrorCode::kIo, "standard output: could not be written"});
    return kExitOk;
  }
  console.end("stopped");
  return fail(outcome.error());
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  try {
    return CommandLine().run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fputs("sonde: error: out of memory: expected room for what was asked for, found none\n",
               stderr);
    return kExitDevice;
  } catch (const std::exception& bug) {
    std::string what = bug.what();
    for (char& c : what) c = c == '\n' ? ' ' : c;
    std::fprintf(stderr, "sonde: bug: %s\n", what.c_str());
    return kExitBug;
  }
}

}  // namespace nav::app
