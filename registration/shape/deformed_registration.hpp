// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "registration/acceptance.hpp"
#include "registration/shape/deformable_registration.hpp"

namespace nav::registration {

/// A registration of a patient whose tissue is deformed relative to the CT, judged like that of a
/// patient whose tissue is not: the CT is deformed as the ultrasound images show, and they are
/// registered to it.
struct DeformedRegistration {
  DeformableResult tissue;  ///< Deformation about the common pose.
  /// Registration of the images to the deformed CT: the tissue at y in the deformed CT lies at y +
  /// tissue.field(y) in the CT. Its uncertainty includes that of the field: tissue.displacement_mm,
  /// RMS, everywhere. Absent if no deformation is supported.
  std::optional<ImageRegistrationResult> in_bent_ct;
  double settled_mm;  ///< Distance of in_bent_ct from the common pose, RMS over the sweep.
};

/// The deformed CT: bent(y) = ct(y + field(y)), trilinear. Voxels where the field is zero are
/// unchanged; voxels where it points out of the CT are air.
Result<Volume> bent_ct(const Volume& ct, const SplineField& field);

/// Fits a deformation about a common pose, which may be accepted or not. If the deformation is
/// supported, it registers the images to the deformed CT. solver: the options of the common pose.
/// Deterministic. Errors: those of motion_evidence(), refine_deformable() and register_sweep().
Result<DeformedRegistration> register_deformed(
    const Volume& ct, const Sweep& sweep, const Pose& common, const DeformableOptions& fit,
    const ImageRegistrationOptions& solver, Diagnostics& diagnostics,
    const std::function<bool(double fraction)>& progress = {});

/// The verdict on the whole registration. in_bent_ct must meet the limits of an undeformed patient,
/// with a cost of at most 0.3, because a field explains a part of any CT. It must have stayed near
/// the common pose, and the fields of the two halves of the images must agree. Precondition:
/// in_bent_ct is present.
Decision decide(const DeformedRegistration& deformed, const AcceptanceLimits& limits,
                const Point<frames::Ct>& target);

}  // namespace nav::registration
