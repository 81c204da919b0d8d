// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "registration/acceptance.hpp"
#include "registration/motion/phase_registration.hpp"

namespace nav::registration {

/// A registration of a breathing patient, judged like that of a patient who lies still: the
/// ultrasound images are moved to where they would lie if the patient held their breath at rest,
/// and are registered again.
struct MovingRegistration {
  /// Says whether images that were left out of the fit support a motion with the breath.
  PhaseResult phases;
  PhaseMotion motion;  ///< Poses by phase, shifted so that the pose at rest is that of at_rest.
  /// [0, 1): the sweep's centre moves least about this phase, see rest_phase().
  double rest_phase;
  /// Registration of the images near rest, with the motion removed; absent if no motion is
  /// supported.
  std::optional<ImageRegistrationResult> at_rest{};
  /// The images that at_rest registered; present if at_rest is.
  std::optional<Sweep> held_still{};
  /// Distance of at_rest from the pose that the phases gave, RMS over the sweep, mm.
  double settled_mm;
};

/// Says if a motion with the breath may explain a poor common pose: the solve did not fail, and
/// enough of the sweep is inside the CT. A motion raises the cost, makes halves of the sweep
/// disagree, and may leave no minimum that determines all directions; it affects neither of the two
/// conditions.
bool may_be_moving(const ImageRegistrationResult& common, const AcceptanceLimits& limits);

/// Middle of the third of the breath in which a point of the CT moves least: the end of expiration
/// in quiet breathing (Lujan et al. 1999, Med. Phys. 26). [0, 1), in steps of 1/64.
double rest_phase(const PhaseMotion& motion, const Point<frames::Ct>& at_mean);

/// Fits the motion with the breath about a common pose, which may be accepted or not. If the motion
/// is supported, it registers the images of the half of the breath around rest with the motion
/// removed: each image is moved by P(rest)⁻¹ P(phase). P is fitted to the breaths that the image is
/// not part of, so that no image is explained by a motion that was fitted to it. Farther from rest,
/// breaths differ from each other. phases: see refine_by_phase(). solver: the options of the common
/// pose. Deterministic. Errors: those of refine_by_phase(), make_ct_channels() and
/// register_sweep().
Result<MovingRegistration> register_moving(
    const Volume& ct, const Sweep& sweep, std::span<const double> phases, const Pose& common,
    const PhaseOptions& fit, const ImageRegistrationOptions& solver, Diagnostics& diagnostics,
    const std::function<bool(double fraction)>& progress = {});

/// The verdict on the whole registration: at_rest must meet the limits of a patient who lies still,
/// and must have stayed where the phases put it. Precondition: at_rest is present.
Decision decide(const MovingRegistration& moving, const AcceptanceLimits& limits,
                const Point<frames::Ct>& target);

}  // namespace nav::registration
