// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "app/console.hpp"
#include "app/report.hpp"
#include "nav/sweep.hpp"
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

/// Motion by phase and deformation about a registration, each with the choice of model and why.
/// What the data do not support, or cannot show, is said there and reported, and is no error.
/// Members `breath` and `deformable` (docs/json.md); null where not asked for.
Result<Json> refine_motion(const Volume& ct, const Sweep& sweep,
                           const Transform<frames::Ct, frames::Reference>& ct_from_reference,
                           const Point<frames::Ct>& target, const MotionOptions& options,
                           const registration::ImageRegistrationOptions& solver, Console& console);

}  // namespace nav::app
