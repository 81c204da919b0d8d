// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "registration/acceptance.hpp"
#include "registration/shape/deformable_registration.hpp"

namespace nav::registration {

/// A registration of a patient whose tissue lies otherwise than in the CT, judged as one of a
/// patient who lies as in it: the CT is bent as the pictures say, and they are registered to it.
struct DeformedRegistration {
  DeformableResult tissue;  ///< About the common pose.
  /// Of the pictures in the bent CT: what lies at y there lies at y + tissue.field(y) in the CT.
  /// Its uncertainty has that of the field in it: tissue.displacement_mm, RMS, everywhere. Absent
  /// where no deformation is supported.
  std::optional<ImageRegistrationResult> in_bent_ct;
  double settled_mm;  ///< How far it is from the common pose, RMS over the sweep.
};

/// The CT as the tissue lies: bent(y) = ct(y + field(y)), trilinear; unchanged where the field is
/// nothing, air where it points out of the CT.
Result<Volume> bent_ct(const Volume& ct, const SplineField& field);

/// Fits a deformation about a common pose, accepted or not, and where it is
/// supported registers the pictures to the CT so bent. solver: as for the common pose.
/// Deterministic. Errors: those of motion_evidence(), refine_deformable() and register_sweep().
Result<DeformedRegistration> register_deformed(
    const Volume& ct, const Sweep& sweep, const Pose& common, const DeformableOptions& fit,
    const ImageRegistrationOptions& solver, Diagnostics& diagnostics,
    const std::function<bool(double fraction)>& progress = {});

/// The verdict on the whole: the limits of a still patient for in_bent_ct with a cost of at most
/// 0.3 (a field explains a part of any CT), that it stayed near the common pose, and that fields of
/// two halves of the pictures agree. Precondition: in_bent_ct.
Decision decide(const DeformedRegistration& deformed, const AcceptanceLimits& limits,
                const Point<frames::Ct>& target);

}  // namespace nav::registration
