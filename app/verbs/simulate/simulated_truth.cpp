// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/simulate/simulated_truth.hpp"

namespace nav::app {
namespace {

io::Json json_of_vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

io::Json json_of_timing(const sim::SimulatedSessionOptions& o) {
  const auto ms = [](Duration d) { return 1e3 * to_seconds(d); };
  return {{"kind", to_string(o.tracker)},
          {"rate_hz", o.timing.rate_hz},
          {"latency_ms", ms(o.timing.latency)},
          {"jitter_ms", ms(o.timing.jitter)},
          {"clock_offset_ms", ms(o.timing.clock_offset)},
          {"drift_ppm", o.timing.drift_ppm},
          {"loss_begins", o.timing.loss_begins},
          {"loss_ends", o.timing.loss_ends},
          {"picture_stamp_offset_ms", ms(o.image_timing.stamp_offset)},
          {"picture_latency_ms", ms(o.image_timing.latency)}};
}

io::Json json_of_breathing(const sim::BreathingOptions& o) {
  return {{"kind", to_string(o.kind)},
          {"period_s", o.period_s},
          {"period_variation", o.period_variation},
          {"amplitude_variation", o.amplitude_variation},
          {"sharpness", o.sharpness},
          {"amplitude_mm", json_of_vector(o.amplitude_mm)},
          {"lag_s", o.lag_s},
          {"centre_mm", json_of_vector(o.centre_mm)},
          {"extent_mm", json_of_vector(o.extent_mm)},
          {"turn_rad", json_of_vector(o.turn_rad)},
          {"stretch", o.stretch}};
}

/// JSON of the deformation; null when there is none.
io::Json json_of_deformation(const sim::SimulatedSession& session) {
  if (session.deformation() == nullptr) return nullptr;
  io::Json json = {{"largest_mm", session.options().deformation.largest_mm},
                   {"bumps", io::Json::array()}};
  for (const sim::WarpBump& bump : session.deformation()->bumps()) {
    json["bumps"].push_back({{"centre_ct_mm", json_of_vector(bump.centre_mm)},
                             {"sigma_mm", json_of_vector(bump.sigma_mm)},
                             {"peak_mm", json_of_vector(bump.peak_mm)}});
  }
  json["targets_now_ct_mm"] = io::Json::array();
  for (const auto& p : session.patient().targets()) {
    json["targets_now_ct_mm"].push_back(json_of_vector(session.deformation()->apply(p.mm)));
  }
  return json;
}

void add_faults(io::Json& list, const char* stream, const std::vector<sim::FaultRecord>& faults) {
  for (const auto& fault : faults) {
    list.push_back({{"stream", stream},
                    {"kind", to_string(fault.kind)},
                    {"sample", fault.sample},
                    {"received_s", to_seconds(fault.received)}});
  }
}

/// Errors of tracker, calibration, scanner and probe that the patient does not have.
io::Json json_of_errors(const sim::SimulatedSessionOptions& o) {
  return {{"tracker_noise_mm", o.tracker_noise_mm},
          {"calibration_mm", o.calibration_mm},
          {"calibration_rad", o.calibration_rad},
          {"image_delay_ms", 1e3 * to_seconds(o.image_timing.stamp_offset)},
          {"sound_speed", o.probe.sound_speed},
          {"layered_speed", o.probe.layered_speed},
          {"noise_level_db", o.probe.noise_level_db},
          {"tgc_error_db", o.probe.tgc_error_db},
          {"clutter_level_db", o.probe.clutter_level_db},
          {"reverberation", o.probe.reverberation},
          {"gas_haze_db", o.probe.gas_haze_db},
          {"persistence", o.probe.persistence},
          {"pressure_mm", o.pressure_mm},
          {"stand_off_mm", o.probe.stand_off_mm}};
}

io::Json json_of_needle(const sim::NeedleInsertion& needle) {
  const auto& o = needle.options();
  return {{"kind", to_string(o.bending.kind)},
          {"curvature_per_mm", o.bending.curvature_per_mm},
          {"tip_force_n", o.bending.tip_force_n},
          {"youngs_modulus_gpa", o.bending.youngs_modulus_gpa},
          {"outer_mm", o.bending.outer_mm},
          {"inner_mm", o.bending.inner_mm},
          {"bevel_rad", o.bending.bevel_rad},
          {"length_mm", o.length_mm},
          {"path_mm", needle.path_mm()},
          {"speed_mm_s", needle.speed_mm_s()},
          {"entry_ct_mm", json_of_vector(needle.plan().entry_ct.mm)},
          {"target_ct_mm", json_of_vector(needle.plan().target_ct.mm)},
          {"needle_from_tip_mm", json_of(needle.hub_from_needle().matrix())}};
}

/// JSON of the needle at one image.
io::Json json_of_needle(const sim::NeedleTruth& needle, const sim::Warp& warp) {
  return {{"inserted_mm", needle.inserted_mm},
          {"ct_from_straight_tip_mm", json_of(needle.ct_from_needle.matrix())},
          {"straight_tip_ct_mm", json_of_vector(needle.straight_tip_ct.mm)},
          {"tip_ct_mm", json_of_vector(needle.tip_ct.mm)},
          {"rest_tip_ct_mm", json_of_vector(warp.invert(needle.tip_ct.mm))},
          {"tip_error_mm", needle.tip_error_mm}};
}

io::Json json_of_frame(const sim::SimulatedSession& session, const RecordedImage& frame) {
  const sim::ImageTruth truth = session.truth(static_cast<int>(frame.sequence));
  io::Json json = {{"sequence", frame.sequence},
                   {"physical_s", to_seconds(truth.physical)},
                   {"stamped_s", to_seconds(frame.stamped)},
                   {"ct_from_image_mm", json_of(truth.ct_from_image.matrix())},
                   {"rest_ct_from_image_mm", json_of(truth.rest.ct_from_image.matrix())},
                   {"deformation_rms_mm", truth.rest.deformation_rms_mm},
                   {"breath", truth.breathing.cycle},
                   {"phase", truth.breathing.phase},
                   {"depth", truth.breathing.depth},
                   {"lagging_depth", truth.breathing.lagging_depth}};
  if (truth.needle) json["needle"] = json_of_needle(*truth.needle, *truth.warp);
  return json;
}

}  // namespace

io::Json truth_of(const sim::SimulatedSession& session, const SimulatedRecording& recording) {
  const auto& o = session.options();
  io::Json json;
  json["verb"] = "simulate";
  json["truth"] = 1;
  json["simulated"] = true;
  json["version"] = SONDE_VERSION;
  json["family"] = o.family;
  json["contrast"] = o.contrast ? io::Json(sim::to_string(*o.contrast)) : io::Json(nullptr);
  json["seed"] = o.seed;
  json["path"] = {{"kind", o.path.recorded ? "recorded" : to_string(o.path.kind)},
                  {"length_mm", o.path.length_mm},
                  {"angle_rad", o.path.angle_rad},
                  {"unevenness", o.path.unevenness}};
  json["errors"] = json_of_errors(o);
  json["ct_from_reference_mm"] = json_of(session.ct_from_reference().matrix());
  json["probe_from_image_mm"] = json_of(session.probe_from_image().matrix());
  json["calibration_mm"] = json_of(session.calibration().matrix());
  json["image_from_pixels_mm"] = json_of(image_from_pixels(session.grid()));
  json["tracker"] = json_of_timing(o);
  json["breathing"] = json_of_breathing(session.breathing().options());
  json["deformation"] = json_of_deformation(session);
  if (session.needle()) json["needle"] = json_of_needle(*session.needle());
  json["targets_ct_mm"] = io::Json::array();
  for (const auto& p : session.patient().targets()) {
    json["targets_ct_mm"].push_back(json_of_vector(p.mm));
  }
  json["landmarks_ct_mm"] = io::Json::object();
  for (const auto& landmark : session.patient().landmarks()) {
    json["landmarks_ct_mm"][landmark.name] = json_of_vector(landmark.position_ct.mm);
  }
  json["faults"] = io::Json::array();
  add_faults(json["faults"], "probe", recording.probe_faults);
  add_faults(json["faults"], "reference", recording.reference_faults);
  add_faults(json["faults"], "needle", recording.needle_faults);
  add_faults(json["faults"], "pictures", recording.frame_faults);
  json["frames"] = io::Json::array();
  for (const auto& frame : recording.frames) {
    json["frames"].push_back(json_of_frame(session, frame));
  }
  return json;
}

}  // namespace nav::app
