// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "registration/acceptance.hpp"
#include "registration/motion/phase_registration.hpp"

namespace nav::registration {

/// A registration of a patient who breathes, judged as one of a patient who lies still: pictures
/// are put where they would lie, had he held his breath at rest, and registered again.
struct MovingRegistration {
  PhaseResult phases;  ///< Whether pictures that were left out support a motion with the breath.
  PhaseMotion motion;  ///< Poses by phase, settled so that the one at rest is at_rest's.
  double rest_phase;   ///< [0, 1): about which the sweep's centre moves least, see rest_phase().
  /// Of the pictures near rest without the motion; absent where none is supported.
  std::optional<ImageRegistrationResult> at_rest;
  std::optional<Sweep> held_still;  ///< Those pictures; present with at_rest.
  /// How far at_rest is from where the phases had put it, RMS over the sweep, mm.
  double settled_mm;
};

/// Whether a motion with the breath may be what a common pose lacks: the solve ended, and enough of
/// the sweep is inside the CT. A motion raises the cost and tears halves of the sweep apart, and
/// may leave no minimum that determines all directions; it does neither of these two.
bool may_be_moving(const ImageRegistrationResult& common, const AcceptanceLimits& limits);

/// Middle of that third of the breath in which a point of the CT moves least: the end of expiration
/// in quiet breathing (Lujan et al. 1999, Med. Phys. 26). [0, 1), in steps of 1/64.
double rest_phase(const PhaseMotion& motion, const Point<frames::Ct>& at_mean);

/// Fits the motion with the breath about a common pose, accepted or not, and where it is supported
/// registers the pictures of that half of the breath about rest, held still: each moved by
/// P(rest)⁻¹ P(phase), P from those breaths that it is not of, so that no picture is explained by a
/// motion that was fitted to it. Farther from rest breaths differ from each other. phases: as
/// refine_by_phase(). solver: as for the common pose. Deterministic. Errors: those of
/// refine_by_phase(), make_ct_channels() and register_sweep().
Result<MovingRegistration> register_moving(
    const Volume& ct, const Sweep& sweep, std::span<const double> phases, const Pose& common,
    const PhaseOptions& fit, const ImageRegistrationOptions& solver, Diagnostics& diagnostics,
    const std::function<bool(double fraction)>& progress = {});

/// The verdict on the whole: the limits of a still patient for at_rest, and that it stayed where
/// the phases had put it. Precondition: at_rest.
Decision decide(const MovingRegistration& moving, const AcceptanceLimits& limits,
                const Point<frames::Ct>& target);

}  // namespace nav::registration
