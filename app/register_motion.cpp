// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/register_motion.hpp"

#include <cmath>
#include <sstream>

#include "registration/deformable_registration.hpp"
#include "registration/patches.hpp"
#include "registration/phase_registration.hpp"
#include "registration/shadow_mask.hpp"
#include "registration/sweep_points.hpp"

namespace nav::app {
namespace {

using Pose = Transform<frames::Ct, frames::Reference>;

constexpr double kShortestBreathS = 1;
constexpr double kLongestBreathS = 20;
constexpr int kReportedPhases = 8;
// Both motions are smooth and have many unknowns: a middle level with many patches.
constexpr registration::LevelOptions kLevel{1.6, 9, 1500, 1.0};
constexpr double kSigmaPerStep = 0.75;
constexpr double kReachMm = 20;

/// What both refinements look at.
struct Evidence {
  registration::CtChannels ct;
  registration::PatchSet patches;
};

Result<Evidence> evidence(const Volume& ct, const Sweep& sweep, const Pose& pose,
                          const registration::ImageRegistrationOptions& solver) {
  const auto masks = registration::shadow_masks(sweep, solver.mask);
  if (!masks) return masks.error();
  const auto points = registration::sweep_points(sweep, *masks);
  const double sigma_mm = kSigmaPerStep * kLevel.sample_step_mm;
  auto channels = registration::make_ct_channels(
      ct, registration::box_around(points, {pose}, kReachMm), sigma_mm);
  if (!channels) return channels.error();
  return Evidence{std::move(*channels),
                  registration::make_patches(sweep, *masks, kLevel, sigma_mm)};
}

/// A refinement that the data could not even be tried on.
Json not_tried(const std::string& reason) { return {{"supported", false}, {"reason", reason}}; }

void say(const std::string& model, const Json& outcome, Console& console) {
  console.report(outcome["supported"].get<bool>() ? Severity::kInfo : Severity::kWarning,
                 "register", model + ": " + outcome["reason"].get<std::string>());
}

Json json_of(const registration::PhaseResult& found, double period_s,
             const Point<frames::Ct>& target) {
  Json json = {{"supported", found.supported},
               {"reason", found.reason},
               {"period_s", period_s},
               {"pictures", found.pictures},
               {"amplitude_mm", found.motion.amplitude_mm(target)},
               {"rigid_cost", found.rigid_cost},
               {"final_cost", found.final_cost},
               {"held_out_rigid", found.held_out_rigid},
               {"held_out_moving", found.held_out_moving},
               {"gain_sigmas", found.gain_sigmas},
               {"phases", Json::array()}};
  for (int i = 0; i < kReportedPhases; ++i) {
    const double phase = static_cast<double>(i) / kReportedPhases;
    json["phases"].push_back(
        {{"phase", phase},
         {"ct_from_reference_mm", app::json_of(found.motion.ct_from_reference(phase).matrix())}});
  }
  return json;
}

Json json_of(const registration::DeformableResult& found, const Point<frames::Ct>& target) {
  const Eigen::Vector3d moved = found.field.displacement(target.mm);
  return {{"supported", found.supported},
          {"reason", found.reason},
          {"displacement_at_target_mm", {moved.x(), moved.y(), moved.z()}},
          {"rigid_cost", found.rigid_cost},
          {"final_cost", found.final_cost},
          {"held_out_rigid", found.held_out_rigid},
          {"held_out_deformed", found.held_out_deformed},
          {"gain_sigmas", found.gain_sigmas},
          {"min_determinant", found.min_determinant}};
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

Result<Json> refine_motion(const Volume& ct, const Sweep& sweep, const Pose& ct_from_reference,
                           const Point<frames::Ct>& target, const MotionOptions& options,
                           const registration::ImageRegistrationOptions& solver, Console& console) {
  Json json = {{"breath", nullptr}, {"deformable", nullptr}};
  if (!options.breath_period_s && !options.deformable) return json;
  const auto seen = evidence(ct, sweep, ct_from_reference, solver);
  if (!seen) return seen.error();
  if (options.breath_period_s) {
    registration::PhaseOptions fit;
    fit.ridge = solver.ridge;
    fit.threads = solver.threads;
    const auto found = registration::refine_by_phase(
        seen->ct, seen->patches, phases_by_period(sweep, *options.breath_period_s),
        ct_from_reference, fit);
    json["breath"] = found ? json_of(*found, *options.breath_period_s, target)
                           : not_tried(found.error().message);
    say("breath", json["breath"], console);
  }
  if (options.deformable) {
    registration::DeformableOptions fit;
    fit.ridge = solver.ridge;
    const auto found =
        registration::refine_deformable(seen->ct, seen->patches, ct_from_reference, fit);
    json["deformable"] = found ? json_of(*found, target) : not_tried(found.error().message);
    say("deformable", json["deformable"], console);
  }
  return json;
}

}  // namespace nav::app
