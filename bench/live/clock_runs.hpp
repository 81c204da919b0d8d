// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::bench {

struct ClockRunsOptions {
  double seconds = 3600;  ///< Length of each run, [60, 86400].
  int steps = 200;        ///< Runs with a clock that is set by 150 ms, per row, >= 1.
  std::uint64_t seed = 1;
};

/// Clock model (tracking/clock_model.hpp) against a device whose clock is 100 ppm fast, by a link
/// with a least delay of 8 ms, an exponential tail of 5 ms on average and 20 % losses.
struct ClockRuns {
  double rate_hz = 0;
  double stamp_ms = 0;  ///< Resolution of the device's stamps.
  /// Error of the time of acquisition but for a constant, from 10 s on.
  double error_p95_ms = 0, error_max_ms = 0;
  double skew_ppm = 0;         ///< At the end.
  std::uint64_t rejected = 0;  ///< Samples whose time was not believed.
  int false_steps = 0;         ///< Epochs that began without a step.
  double steps_found = 0;      ///< Share of clocks set by 150 ms that were found in 200 ms.
  double ns_per_sample = 0;    ///< Processor time.
};

/// \p progress: share that is done.
Result<std::vector<ClockRuns>> measure_clock_runs(const ClockRunsOptions& options,
                                                  const std::function<void(double)>& progress);
std::string to_text(const std::vector<ClockRuns>& rows);

}  // namespace nav::bench
