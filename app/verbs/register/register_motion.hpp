// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "app/console.hpp"
#include "app/report.hpp"
#include "nav/sweep.hpp"
#include "registration/acceptance.hpp"
#include "registration/image_registration.hpp"

namespace nav::app {

/// Refinements of 'sonde register' after the common pose of all images.
struct MotionOptions {
  std::optional<double> breath_period_s;  ///< [1, 20]; gives each image its phase of the breath.
  bool deformable = false;                ///< Refine a smooth displacement of the tissue.
};

/// Rejects a period out of its range.
Result<void> validate(const MotionOptions& options);

/// Phase of the breath at each image, [0, 1), 0 at the first. Precondition: period_s > 0.
std::vector<double> phases_by_period(const Sweep& sweep, double period_s);

/// Registration after the refinements of MotionOptions.
struct MotionOutcome {
  /// Result with the common pose, or with the pose at rest when the images show that the patient
  /// moves with the breath.
  registration::ImageRegistrationResult result;
  registration::Decision decision;  ///< Decision about result.
  /// Members `breath` and `deformable` (docs/json.md); null for refinements that were not
  /// requested.
  io::Json json;
};

/// Refines a registration by motion with the breath and by deformation, and says for each which
/// model was chosen and why. A motion that the data support replaces the common pose, accepted or
/// not, and the same limits judge it. A refinement that the data do not support or cannot show is
/// reported in json and as a message; it is not an error. limits: of the common pose.
Result<MotionOutcome> refine_motion(const Volume& ct, const Sweep& sweep,
                                    const registration::ImageRegistrationResult& common,
                                    const Point<frames::Ct>& target, const MotionOptions& options,
                                    const registration::ImageRegistrationOptions& solver,
                                    const registration::AcceptanceLimits& limits, Console& console);

}  // namespace nav::app
