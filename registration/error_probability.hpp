// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/transform.hpp"
#include "registration/image_registration.hpp"

namespace nav::registration {

/// A pose whose target error exceeds this is wrong, mm.
inline constexpr double kWrongMm = 3;

/// Probability that the target error of a registration exceeds kWrongMm, [0, 1], from all its
/// evidence together: cost, margin to another minimum, predicted error at the target,
/// disagreements of halves of the images, distance to a lower cost, score against random poses. A
/// logistic regression, fitted to registrations of simulated patients at all levels of errors by
/// tools/fit_decision.py; docs/registration-experiments.md shows how it holds on others. It holds
/// for the usual effort and kLc2. 1 if the result has no covariance.
double error_probability(const ImageRegistrationResult& result, const Point<frames::Ct>& target);

}  // namespace nav::registration
