// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "registration/image_registration.hpp"
#include "registration/lc2_cost.hpp"
#include "registration/sweep_points.hpp"

namespace nav::registration {

/// Asks the cost at 12 poses about a pose, and where one is lower, at those about that one, at most
/// kBasinSteps times. No derivatives, which a solver may have been led astray by.
BasinCheck check_basin(const Lc2Cost& cost, const SweepPoints& sweep, const Pose& pose);
inline constexpr int kBasinSteps = 6;

}  // namespace nav::registration
