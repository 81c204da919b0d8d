// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/register/register_motion.hpp"

#include <cmath>
#include <sstream>

#include "registration/motion/moving_registration.hpp"
#include "registration/shape/deformed_registration.hpp"

namespace nav::app {
namespace {

constexpr double kShortestBreathS = 1;
constexpr double kLongestBreathS = 20;
constexpr int kReportedPhases = 8;

/// JSON of a refinement that could not be tried with these data.
io::Json not_tried(const std::string& reason) { return {{"supported", false}, {"reason", reason}}; }

void say(const std::string& model, const io::Json& outcome, Console& console) {
  console.report(outcome["supported"].get<bool>() ? Severity::kInfo : Severity::kWarning,
                 "register", model + ": " + outcome["reason"].get<std::string>());
}

io::Json phases_of(const registration::PhaseMotion& motion) {
  io::Json phases = io::Json::array();
  for (int i = 0; i < kReportedPhases; ++i) {
    const double phase = static_cast<double>(i) / kReportedPhases;
    phases.push_back({{"phase", phase},
                      {"ct_from_reference_mm", json_of(motion.ct_from_reference(phase).matrix())}});
  }
  return phases;
}

io::Json as_json(const registration::PhaseResult& found, double period_s) {
  return {{"supported", found.supported},
          {"accepted", false},
          {"reason", found.reason},
          {"period_s", period_s},
          {"pictures", found.images},
          {"rigid_cost", found.rigid_cost},
          {"final_cost", found.final_cost},
          {"held_out_rigid", found.held_out_rigid},
          {"held_out_moving", found.held_out_moving},
          {"gain_sigmas", found.gain_sigmas}};
}

/// JSON with all values needed to evaluate the field at any point; null when it is not supported.
io::Json as_json(const registration::SplineField& field, bool supported) {
  if (!supported) return nullptr;
  const auto& c = field.coefficients();
  const Eigen::Vector3d& origin = field.origin();
  return {{"origin_ct_mm", {origin.x(), origin.y(), origin.z()}},
          {"spacing_mm", field.spacing_mm()},
          {"size", field.size()},
          {"coefficients_mm", std::vector<double>(c.data(), c.data() + c.size())}};
}

io::Json as_json(const registration::DeformableResult& found, const Point<frames::Ct>& target) {
  const Eigen::Vector3d moved = found.field.displacement(target.mm);
  return {{"supported", found.supported},
          {"model", found.supported ? "free-form" : "rigid"},
          {"reason", found.reason},
          {"displacement_at_target_mm", {moved.x(), moved.y(), moved.z()}},
          {"rigid_cost", found.rigid_cost},
          {"final_cost", found.final_cost},
          {"held_out_rigid", found.held_out_rigid},
          {"held_out_deformed", found.held_out_deformed},
          {"gain_sigmas", found.gain_sigmas},
          {"displacement_rms_mm", found.displacement_mm},
          {"halves_disagreement_mm", found.halves_disagreement_mm},
          {"min_determinant", found.min_determinant},
          {"max_gradient", found.max_gradient},
          {"one_to_one", found.max_gradient < 1},
          {"bending_energy_mm", found.bending_energy_mm},
          {"field", as_json(found.field, found.supported)},
          {"iterations", found.iterations}};
}

}  // namespace

Result<void> validate(const MotionOptions& options) {
  if (!options.breath_period_s) return {};
  const double period_s = *options.breath_period_s;
  if (period_s >= kShortestBreathS && period_s <= kLongestBreathS) return {};
  std::ostringstream text;
  text << "--breath-period: expected " << kShortestBreathS << " to " << kLongestBreathS
       << " s, found " << period_s;
  return Error{ErrorCode::kUsage, text.str()};
}

std::vector<double> phases_by_period(const Sweep& sweep, double period_s) {
  NAV_CHECK(period_s > 0, period_s);
  const Timestamp first = sweep.frames().front().frame.acquired;
  std::vector<double> phases;
  for (const auto& tracked : sweep.frames()) {
    const double breaths = to_seconds(tracked.frame.acquired - first) / period_s;
    phases.push_back(breaths - std::floor(breaths));
  }
  return phases;
}

namespace {

/// JSON of the decision about the common pose.
io::Json json_of_common(const MotionOutcome& outcome) {
  return {{"accepted", outcome.decision.accepted},
          {"reasons", outcome.decision.reasons},
          {pose_key(outcome.decision), json_of(outcome.result.ct_from_reference.matrix())}};
}

/// Replaces the common pose by the motion, and keeps the decision about the common pose in the
/// JSON. A refused motion gets no amplitude and no phases.
void take(const registration::MovingRegistration& moving, const Point<frames::Ct>& target,
          MotionOutcome& outcome) {
  io::Json& json = outcome.json["breath"];
  json["common"] = json_of_common(outcome);
  outcome.decision = registration::decide(moving, {}, target);
  outcome.result = *moving.at_rest;
  json["accepted"] = outcome.decision.accepted;
  json["settled_mm"] = json_number(moving.settled_mm);
  if (!outcome.decision.accepted) {
    json["supported"] = false;
    json["reason"] = moving.phases.reason + ", but with it the registration is refused";
    return;
  }
  json["amplitude_mm"] = moving.motion.amplitude_mm(target);
  json["rest_phase"] = moving.rest_phase;
  json["phases"] = phases_of(moving.motion);
}

/// Refines the motion with the breath. Returns the sweep with that motion removed; absent when no
/// motion was accepted.
std::optional<Sweep> refine_breath(const Volume& ct, const Sweep& sweep,
                                   const Point<frames::Ct>& target, double period_s,
                                   const registration::ImageRegistrationOptions& solver,
                                   Console& console, MotionOutcome& outcome) {
  io::Json& json = outcome.json["breath"];
  std::optional<Sweep> still;
  if (!registration::may_be_moving(outcome.result, {})) {
    json = not_tried(
        "the common pose failed or lacks overlap with the CT, which breathing does not explain");
  } else {
    registration::PhaseOptions fit;
    fit.ridge = solver.ridge;
    fit.threads = solver.threads;
    console.begin("breath");
    auto moving = registration::register_moving(ct, sweep, phases_by_period(sweep, period_s),
                                                outcome.result.ct_from_reference, fit, solver,
                                                console, [&](double fraction) {
                                                  console.progress(fraction);
                                                  return true;
                                                });
    json = moving ? as_json(moving->phases, period_s) : not_tried(moving.error().message);
    if (moving && moving->at_rest) {
      take(*moving, target, outcome);
      if (outcome.decision.accepted) still = std::move(moving->held_still);
    }
    console.end(json["supported"].get<bool>() ? "accepted" : "not supported");
  }
  if (!json.contains("accepted")) json["accepted"] = false;
  say("breath", json, console);
  return still;
}

/// Replaces the result by the registration in the deformed CT, if that is accepted. A refused one
/// only changes the JSON.
void take(const registration::DeformedRegistration& deformed, const Point<frames::Ct>& target,
          MotionOutcome& outcome) {
  io::Json& json = outcome.json["deformable"];
  json["common"] = json_of_common(outcome);
  json["settled_mm"] = json_number(deformed.settled_mm);
  const auto decision = registration::decide(deformed, {}, target);
  json["accepted"] = decision.accepted;
  if (!decision.accepted) {
    json["supported"] = false;
    json["model"] = "rigid";
    json["field"] = nullptr;
    json["reason"] =
        deformed.tissue.reason + ", but the registration in the deformed CT is refused";
    json["refused"] = decision.reasons;
    return;
  }
  outcome.decision = decision;
  outcome.result = *deformed.in_bent_ct;
}

void refine_tissue(const Volume& ct, const Sweep& sweep, const Point<frames::Ct>& target,
                   const registration::ImageRegistrationOptions& solver, Console& console,
                   MotionOutcome& outcome) {
  io::Json& json = outcome.json["deformable"];
  if (!registration::may_be_moving(outcome.result, {})) {
    json = not_tried(
        "the pose failed or lacks overlap with the CT, which deformation does not explain");
  } else {
    registration::DeformableOptions fit;
    fit.ridge = solver.ridge;
    fit.threads = solver.threads;
    console.begin("deformation");
    const auto deformed = registration::register_deformed(
        ct, sweep, outcome.result.ct_from_reference, fit, solver, console, [&](double fraction) {
          console.progress(fraction);
          return true;
        });
    json = deformed ? as_json(deformed->tissue, target) : not_tried(deformed.error().message);
    if (deformed && deformed->in_bent_ct) take(*deformed, target, outcome);
    console.end(json.value("accepted", false) ? "accepted" : "not supported");
  }
  json.emplace("accepted", false);
  say("deformable", json, console);
}

}  // namespace

Result<MotionOutcome> refine_motion(const Volume& ct, const Sweep& sweep,
                                    const registration::ImageRegistrationResult& common,
                                    const Point<frames::Ct>& target, const MotionOptions& options,
                                    const registration::ImageRegistrationOptions& solver,
                                    const registration::AcceptanceLimits& limits,
                                    Console& console) {
  MotionOutcome outcome{common, registration::decide(common, limits, target),
                        io::Json{{"breath", nullptr}, {"deformable", nullptr}}};
  std::optional<Sweep> still;
  if (options.breath_period_s) {
    still = refine_breath(ct, sweep, target, *options.breath_period_s, solver, console, outcome);
  }
  if (options.deformable) {
    refine_tissue(ct, still ? *still : sweep, target, solver, console, outcome);
  }
  return outcome;
}

}  // namespace nav::app
