// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The verbs of ultrasound volumes and of the simulator: predicates, derive, simulate.
#include "app/options/idle_options.hpp"
#include "app/options/option_checks.hpp"
#include "app/options/option_keys.hpp"
#include "app/options/overwriting.hpp"
#include "app/options/predicate_command.hpp"
#include "app/options/verbs.hpp"
#include "app/predicates/predicates.hpp"
#include "sim/anatomy/patient.hpp"
#include "sim/session/simulated_session.hpp"

namespace nav::app {

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
      [&o](std::int64_t) { o.snr.weights = render::features::WindowWeights::kGaussian; },
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

}  // namespace nav::app
