// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/simulate/simulate.hpp"

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <sstream>
#include <string>

#include "app/options/overwriting.hpp"
#include "app/verbs/simulate/hand_of_recording.hpp"
#include "app/verbs/simulate/simulated_truth.hpp"
#include "io/ct.hpp"
#include "sim/anatomy/patient.hpp"
#include "sim/ct_scanner.hpp"
#include "sim/session/patient_of_ct.hpp"

namespace nav::app {
namespace {

constexpr double kRadPerDegree = std::numbers::pi / 180;
constexpr double kUsualBreathMm = 12;

Result<sim::ProbeModel> probe_of(const SimulateOptions& options, const sim::Patient& patient) {
  Result<sim::ProbeModel> probe = options.probe == "standard"
                                      ? Result<sim::ProbeModel>(patient.views.front().probe)
                                      : sim::probe_model_from(options.probe);
  if (!probe) return Error{probe.error().code, probe.error().message + ", or standard"};
  const auto model = sim::acoustic_model_from(options.model);
  if (!model) return model.error();
  probe->model = *model;
  probe->marker_on_other_side = options.mirrored;
  if (options.columns != 0) probe->columns = options.columns;
  if (options.rows != 0) probe->rows = options.rows;
  probe->stand_off_mm = options.stand_off_mm;
  probe->layered_speed = options.layered_speed;
  return probe;
}

/// Usual length of a slide: a convex probe moves over an organ, a linear probe along a part of the
/// neck or a limb, a sector probe within a craniotomy.
double usual_length_mm(sim::ProbeKind probe) {
  switch (probe) {
    case sim::ProbeKind::kConvex:
      return 60;
    case sim::ProbeKind::kLinear:
      return 40;
    case sim::ProbeKind::kSector:
      return 16;
  }
  return 0;
}

Duration milliseconds_of(double ms) { return from_seconds(1e-3 * ms); }

/// Sets the timing of tracker and images. An image with a late stamp arrives no earlier than its
/// stamp.
void set_timing(const SimulateOptions& options, sim::SimulatedSessionOptions& out) {
  out.timing.rate_hz = options.tracker_rate_hz;
  out.timing.latency = milliseconds_of(options.latency_ms);
  out.timing.jitter = milliseconds_of(options.jitter_ms);
  out.timing.clock_offset = milliseconds_of(options.clock_offset_ms);
  out.timing.drift_ppm = options.clock_drift_ppm;
  out.timing.loss_begins = options.loss;
  out.image_timing.stamp_offset = milliseconds_of(options.image_offset_ms);
  out.image_timing.latency = std::max(out.image_timing.latency, out.image_timing.stamp_offset);
}

/// Breathing in the usual direction, scaled to the wanted amplitude. A recorded CT may lie
/// anywhere, so its motion is centred on the targets.
Result<sim::BreathingOptions> breathing_of(const SimulateOptions& options,
                                           const sim::Patient& patient) {
  sim::BreathingOptions breathing;
  const auto kind = sim::breathing_kind_from(options.breathing);
  if (!kind) return kind.error();
  breathing.kind = *kind;
  breathing.period_s = options.breathing_period_s.value_or(breathing.period_s);
  breathing.lag_s = std::min(breathing.lag_s, 0.5 * breathing.period_s);
  breathing.amplitude_mm *=
      options.breathing_mm.value_or(kUsualBreathMm) / -breathing.amplitude_mm.z();
  const auto targets = patient.anatomy->targets();
  if (options.patient_ct.empty() || targets.empty()) return breathing;
  breathing.centre_mm.setZero();
  for (const auto& target : targets) {
    breathing.centre_mm += target.mm / static_cast<double>(targets.size());
  }
  return breathing;
}

/// Options of the needle; absent when the user wants none.
Result<std::optional<sim::NeedleInsertionOptions>> needle_of(const SimulateOptions& options) {
  if (options.needle == "none") return std::optional<sim::NeedleInsertionOptions>();
  const auto kind = sim::bending_kind_from(options.needle);
  if (!kind) return Error{kind.error().code, "--" + kind.error().message + " (or none)"};
  sim::NeedleInsertionOptions needle;
  needle.bending.kind = *kind;
  needle.bending.bevel_rad = options.needle_bevel_deg * kRadPerDegree;
  needle.aside_at_target_mm = options.needle_bending_mm;
  needle.speed_mm_s = options.needle_speed_mm_s;
  needle.length_mm = options.needle_length_mm;
  return std::optional(needle);
}

/// Duration of the recording: what is asked for, or all of a recorded hand, or 4 s.
Result<double> duration_of(const SimulateOptions& options, const sim::RecordedHand* hand) {
  constexpr double kUsualDurationS = 4;
  if (hand == nullptr) return options.duration_s.value_or(kUsualDurationS);
  const double longest = to_seconds(hand->duration());
  if (options.duration_s && *options.duration_s > longest) {
    std::ostringstream text;
    text << "--duration-s: expected at most " << longest << " s, the length of "
         << options.path_from.string() << ", found " << *options.duration_s;
    return Error{ErrorCode::kUsage, text.str()};
  }
  return options.duration_s.value_or(longest);
}

Result<sim::SimulatedSessionOptions> session_options(const SimulateOptions& options,
                                                     const sim::Patient& patient,
                                                     Console& console) {
  sim::SimulatedSessionOptions out;
  const auto probe = probe_of(options, patient);
  if (!probe) return probe.error();
  const auto path = sim::hand_path_kind_from(options.path);
  if (!path) return path.error();
  const auto tracker = sim::tracker_kind_from(options.tracker);
  if (!tracker) return tracker.error();
  const auto breathing = breathing_of(options, patient);
  if (!breathing) return breathing.error();
  out.family = patient.family;
  out.contrast = patient.contrast;
  out.seed = options.seed;
  out.path.kind = *path;
  out.path.length_mm = options.length_mm > 0 ? options.length_mm : usual_length_mm(probe->kind);
  out.path.angle_rad = options.angle_deg * kRadPerDegree;
  out.path.unevenness = options.unevenness;
  out.pressure_mm = options.pressure_mm;
  out.frame_rate_hz = options.frame_rate_hz;
  out.probe = *probe;
  out.standard_view = options.probe == "standard";
  out.tracker = *tracker;
  out.breathing = *breathing;
  out.deformation.largest_mm = options.deform_mm;
  const auto needle = needle_of(options);
  if (!needle) return needle.error();
  out.needle = *needle;
  set_timing(options, out);
  if (options.level != "none") {
    const auto level = sim::error_level_from(options.level);
    if (!level) return level.error();
    sim::set_errors(*level, out);
  }
  if (!options.path_from.empty()) {
    const auto hand = hand_of_recording(options.path_from, options.path_config, console);
    if (!hand) return hand.error();
    out.path.recorded = *hand;
  }
  const auto duration = duration_of(options, out.path.recorded.get());
  if (!duration) return duration.error();
  out.duration_s = *duration;
  const auto faults = sim::FaultPlan::from(options.faults, options.seed);
  if (!faults) return Error{faults.error().code, "--" + faults.error().message};
  out.pose_faults = out.frame_faults = *faults;
  return out;
}

Result<sim::Patient> patient_of(const SimulateOptions& options, Console& console) {
  const auto contrast = sim::contrast_from(options.contrast);
  if (!contrast) return Error{contrast.error().code, "--" + contrast.error().message};
  if (options.patient_ct.empty())
    return sim::make_patient(options.family, {options.seed, *contrast});
  const auto ct = io::read_ct(options.patient_ct, console);
  if (!ct) return ct.error();
  sim::CtPatientOptions made;
  made.seed = options.seed;
  if (options.look_at_mm) {
    made.about = Point<frames::Ct>{Eigen::Vector3d(options.look_at_mm->data())};
  }
  return sim::make_patient_of_ct(*ct, made);
}

std::filesystem::path truth_file(const SimulateOptions& options) {
  if (!options.truth.empty()) return options.truth;
  return std::filesystem::path(options.out).replace_extension(".truth.json");
}

/// Rejects output files that would overwrite each other.
Result<void> check_files(const SimulateOptions& options) {
  namespace fs = std::filesystem;
  const auto place = [](const fs::path& path) { return fs::absolute(path).lexically_normal(); };
  const auto apart = [&](const std::string& what, const fs::path& path, const std::string& from,
                         const fs::path& other) -> Result<void> {
    if (place(path) != place(other)) return {};
    return Error{ErrorCode::kUsage, what + ": expected another file than " + from + ", found " +
                                        path.string() + " for both"};
  };
  if (auto ok = apart("--truth", truth_file(options), "--out", options.out); !ok) return ok;
  if (options.ct.empty()) return {};
  if (fs::path(options.ct).extension() != ".mha") {
    return Error{ErrorCode::kUsage,
                 "--ct: expected a name that ends in .mha, found " + options.ct.string()};
  }
  if (auto ok = apart("--ct", options.ct, "--out", options.out); !ok) return ok;
  return apart("--ct", options.ct, "--truth", truth_file(options));
}

Result<void> write_ct(const sim::SimulatedSession& session, const SimulateOptions& options) {
  sim::CtOptions ct;
  ct.seed = options.seed;
  ct.spacing_mm = Eigen::Vector3d::Constant(options.ct_spacing_mm);
  // A recorded CT may lie anywhere; patients of a family lie around the origin.
  if (!options.patient_ct.empty()) ct.region = sim::region_of(session.patient());
  const auto volume = sim::scan_ct(session.patient(), ct);
  if (!volume) return Error{volume.error().code, "--ct-spacing-mm: " + volume.error().message};
  return io::write_ct_mha(*volume, options.ct);
}

}  // namespace

Result<void> run_simulate(const SimulateOptions& options, Console& console) {
  if (auto ok = validate(options); !ok) return ok;
  if (auto ok = check_files(options); !ok) return ok;
  if (options.truth.empty()) {
    if (auto ok = reject_foreign({{"truth beside --out", truth_file(options)}}); !ok) return ok;
  }
  console.begin("simulated patient");
  const auto patient = patient_of(options, console);
  if (!patient) return patient.error();
  const auto session_settings = session_options(options, *patient, console);
  if (!session_settings) return session_settings.error();
  const auto session = sim::SimulatedSession::create(*session_settings, *patient);
  if (!session) return session.error();
  console.begin("images");
  const auto recording =
      record(*session, options.out, options.compress, [&](double f) { console.progress(f); });
  if (!recording) return recording.error();
  console.end(std::to_string(recording->frames.size()) + " images");
  const std::filesystem::path truth = truth_file(options);
  if (auto written = write_json(truth_of(*session, *recording), truth.string()); !written) {
    return written;
  }
  if (!options.ct.empty()) {
    console.begin("CT");
    if (auto written = write_ct(*session, options); !written) return written;
    console.end();
  }
  console.say("truth: " + truth.string());
  return {};
}

}  // namespace nav::app
