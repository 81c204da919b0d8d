// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/motion/moving_registration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

#include "nav/check.hpp"
#include "registration/motion/motion_evidence.hpp"
#include "registration/similarity/sweep_points.hpp"

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;

// A breath moves farther than the fine level can capture from the common pose. Patches are spread
// evenly: patches of highest contrast dominate all others and shift a patient who lies still by
// millimetres.
constexpr std::array<LevelOptions, 2> kLevels = {LevelOptions{.sample_step_mm = 2.4,
                                                              .patch_side = 9,
                                                              .patches = 3000,
                                                              .frame_step_mm = 1.0,
                                                              .choice = PatchChoice::kEven},
                                                 LevelOptions{.sample_step_mm = 1.2,
                                                              .patch_side = 9,
                                                              .patches = 6000,
                                                              .frame_step_mm = 1.0,
                                                              .choice = PatchChoice::kEven}};
constexpr int kRestSteps = 64;
constexpr double kRestHalfWidth = 1.0 / 6;
// The pose at rest is found and judged by the images of the half of the breath around rest. Breaths
// differ in depth and length, and one motion for all breaths does not model this. Far from rest
// they differ by a millimetre or two, so that right poses cost more and halves of the sweep
// disagree; near rest they hardly differ.
constexpr double kJudgedHalfWidth = 0.25;
constexpr std::size_t kLeastJudged = 12;

double phase_distance(double a, double b) {
  const double apart = std::abs(a - b);
  return std::min(apart, 1 - apart);
}

/// Marks the images near rest; all images with a phase if there are too few near rest.
std::vector<bool> near_rest(std::span<const double> phases, double rest) {
  std::vector<bool> near;
  for (const double phase : phases) near.push_back(phase_distance(phase, rest) <= kJudgedHalfWidth);
  if (static_cast<std::size_t>(std::ranges::count(near, true)) >= kLeastJudged) return near;
  for (std::size_t i = 0; i < near.size(); ++i) near[i] = !std::isnan(phases[i]);
  return near;
}

/// Images near rest, each moved to its position at rest.
Result<Sweep> hold_still(const Sweep& sweep, std::span<const double> phases,
                         const PhaseResult& found, double rest, const Pose& at_rest) {
  std::vector<TrackedImage> still;
  const auto reference_from_ct = at_rest.inverse();
  const std::vector<bool> near = near_rest(phases, rest);
  for (std::size_t i = 0; i < sweep.frames().size(); ++i) {
    if (!near[i]) continue;
    TrackedImage tracked = sweep.frames()[i];
    const PhaseMotion& judge = found.unseen[static_cast<std::size_t>(found.part[i])];
    tracked.reference_from_image =
        reference_from_ct * judge.ct_from_reference(phases[i]) * tracked.reference_from_image;
    still.push_back(std::move(tracked));
  }
  return Sweep::create(std::move(still), sweep.calibration_id());
}

}  // namespace

bool may_be_moving(const ImageRegistrationResult& common, const AcceptanceLimits& limits) {
  return common.termination != Termination::kFailed && common.overlap >= limits.min_overlap;
}

double rest_phase(const PhaseMotion& motion, const Point<frames::Ct>& at_mean) {
  const Point<frames::Reference> p = motion.ct_from_reference(0).inverse() * at_mean;
  std::vector<Vec> way;
  for (int i = 0; i < kRestSteps; ++i) {
    way.push_back((motion.ct_from_reference(static_cast<double>(i) / kRestSteps) * p).mm);
  }
  const int reach = static_cast<int>(kRestHalfWidth * kRestSteps);
  int rest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kRestSteps; ++i) {
    double farthest = 0;
    for (int k = -reach; k <= reach; ++k) {
      const auto at = static_cast<std::size_t>((i + k + kRestSteps) % kRestSteps);
      farthest = std::max(farthest, (way[at] - way[static_cast<std::size_t>(i)]).norm());
    }
    if (farthest < least) {
      least = farthest;
      rest = i;
    }
  }
  return static_cast<double>(rest) / kRestSteps;
}

Result<MovingRegistration> register_moving(const Volume& ct, const Sweep& sweep,
                                           std::span<const double> phases, const Pose& common,
                                           const PhaseOptions& fit,
                                           const ImageRegistrationOptions& solver,
                                           Diagnostics& diagnostics,
                                           const std::function<bool(double fraction)>& progress) {
  if (phases.size() != sweep.frames().size()) {
    return Error{ErrorCode::kUsage, "phases: expected one for each of " +
                                        std::to_string(sweep.frames().size()) + " images, found " +
                                        std::to_string(phases.size())};
  }
  const auto evidence = motion_evidence(ct, sweep, common, solver.mask, kLevels);
  if (!evidence) return evidence.error();
  std::vector<PhaseLevel> levels;
  for (const MotionEvidence& level : *evidence) levels.push_back({level.ct, level.patches});
  auto found = refine_by_phase(levels, phases, common, fit);
  if (!found) return found.error();
  MovingRegistration moving{
      .phases = *found, .motion = found->motion, .rest_phase = 0, .settled_mm = 0};
  if (!found->supported) return moving;
  moving.rest_phase = rest_phase(found->motion, common * sweep.centroid());
  const Pose expected = found->motion.ct_from_reference(moving.rest_phase);
  auto still = hold_still(sweep, phases, *found, moving.rest_phase, expected);
  if (!still) return still.error();
  auto at_rest = register_sweep(ct, *still, expected, solver, diagnostics, progress);
  if (!at_rest) return at_rest.error();
  moving.settled_mm = apart_mm(*still, expected, at_rest->ct_from_reference);
  moving.motion = found->motion.after(at_rest->ct_from_reference * expected.inverse());
  moving.held_still = std::move(*still);
  moving.at_rest = std::move(*at_rest);
  return moving;
}

Decision decide(const MovingRegistration& moving, const AcceptanceLimits& limits,
                const Point<frames::Ct>& target) {
  NAV_CHECK(moving.at_rest.has_value(), moving.phases.reason);
  Decision decision = decide(*moving.at_rest, limits, target);
  if (!(moving.settled_mm <= kMaxSettlingMm)) {
    std::ostringstream text;
    text.precision(3);
    text << "pose at rest: expected it within " << kMaxSettlingMm
         << " mm of the pose from the phases of the breath, found " << moving.settled_mm << " mm";
    decision.reject(text.str());
  }
  return decision;
}

}  // namespace nav::registration
