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

/// What 'sonde register' refines after the common pose of all pictures.
struct MotionOptions {
  std::optional<double> breath_period_s;  ///< [1, 20]; phases are the pictures' times by it.
  bool deformable = false;                ///< A smooth displacement of the tissue.
};

/// A refusal of a period out of its range.
Result<void> validate(const MotionOptions& options);

/// Phase of each picture, [0, 1), 0 at the first. Precondition: period_s > 0.
std::vector<double> phases_by_period(const Sweep& sweep, double period_s);

/// What the motion options made of a registration. Members `breath` and `deformable` of json are
/// null where not asked for (docs/json.md).
struct MotionOutcome {
  /// The answer: the common pose's, or the pose at rest where the pictures say that the patient
  /// moves with the breath.
  registration::ImageRegistrationResult result;
  registration::Decision decision;  ///< On it.
  io::Json json;
};

/// Motion by phase and deformation about a registration, each with the choice of model and why.
/// A motion that is supported takes the place of the common pose, accepted or not, and is judged by
/// the same limits; limits are those of the common pose. What the data do not support, or cannot
/// show, is said in json and reported, and is no error.
Result<MotionOutcome> refine_motion(const Volume& ct, const Sweep& sweep,
                                    const registration::ImageRegistrationResult& common,
                                    const Point<frames::Ct>& target, const MotionOptions& options,
                                    const registration::ImageRegistrationOptions& solver,
                                    const registration::AcceptanceLimits& limits, Console& console);

}  // namespace nav::app
