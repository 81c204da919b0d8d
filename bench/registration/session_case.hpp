// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nav/result.hpp"
#include "nav/sweep.hpp"
#include "nav/volume.hpp"
#include "registration/similarity/similarity_cost.hpp"
#include "sim/session/simulated_session.hpp"

namespace nav::bench {

/// A simulated session as the registration receives it, with its truth.
struct SessionCase {
  Volume ct;    ///< At the end of expiration, 1.5 x 1.5 x 2 mm.
  Sweep sweep;  ///< Poses without tracker errors.
  registration::Pose truth;
  std::vector<Point<frames::Ct>> targets;
  /// Positions of the targets at the end of expiration: different if the tissue is deformed.
  std::vector<Point<frames::Ct>> lying;
  /// True pose of each image in the CT at its moment: the nearest rigid motion.
  std::vector<registration::Pose> following_truth;
};

/// Runs the session of the family's first standard view. options.probe is replaced by the probe of
/// this view with the acoustic model of options.probe. Errors: those of the simulator.
Result<SessionCase> make_session_case(sim::SimulatedSessionOptions options);

/// RMS distance of the targets from their true positions, mm.
double error_mm(const SessionCase& one, const registration::Pose& found);

}  // namespace nav::bench
