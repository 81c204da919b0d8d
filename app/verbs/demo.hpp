// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "app/options/session_config.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// The simulated procedure: sweep, registration from a planted start error, needle approach.
struct DemoOptions {
  SessionConfig::Output output;  ///< frames: images of the approach; 0: the default of 30.
  SessionConfig::Appearance appearance{};
  SessionConfig::View view{.distance_mm = 560};
  SessionConfig::Quality quality;
  std::vector<CutawayObject> cutaway_objects;
  std::uint64_t seed = 1;
  double start_error_mm = 10;
  double start_error_deg = 8;
  std::optional<std::string> json;  ///< Also write the report here; "-": standard output.
};

/// Runs the demo on the virtual clock. kRefused, after writing the report, when the registration
/// was not accepted.
Result<void> run_demo(const DemoOptions& options, Console& console);

/// Names of the files that the demo writes into the folder, without the numbered images.
std::vector<std::string> demo_outputs();

}  // namespace nav::app
