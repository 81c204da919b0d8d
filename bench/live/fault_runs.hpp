// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::bench {

struct FaultRunsOptions {
  int recordings = 1000;  ///< In turn over all kinds of faults, >= 1.
  double seconds = 20;    ///< Length of each, [5, 600].
  std::uint64_t seed = 1;
};

/// Images of the recordings with one kind of fault.
struct FaultRuns {
  std::string fault;  ///< "none", a name of sim::FaultKind, "everything", or one of this bench.
  int recordings = 0;
  std::uint64_t images = 0;
  std::uint64_t valid = 0;  ///< Shown as valid by a refresh.
  std::uint64_t wrong = 0;  ///< Images among them that are more than kWrongMm from the truth.
  double worst_mm = 0;      ///< Largest distance from the truth of an image shown as valid.
  /// Images that no fault came near to, from 3 s on: 600 ms before and 300 ms after.
  std::uint64_t good = 0;
  /// Good images that were rejected, or degraded or lost where they were shown. Images that a newer
  /// one superseded, and images that came too late to be live, are not counted.
  std::uint64_t withheld = 0;
};

/// An image shown as valid may not be further from the truth at any of its corners.
inline constexpr double kWrongMm = 5;

/// Recordings of a freehand probe and a patient's reference by trackers of all kinds, with noise,
/// delays, losses and a fault that comes again and again in one of the streams, through gate,
/// pairing and navigator (session/navigator.hpp). What is shown as valid is compared with the
/// truth. \p progress: share that is done.
Result<std::vector<FaultRuns>> measure_fault_runs(const FaultRunsOptions& options,
                                                  const std::function<void(double)>& progress);

/// The sum of all rows, named "all".
FaultRuns sum_of(const std::vector<FaultRuns>& rows);
std::string to_text(const std::vector<FaultRuns>& rows);

}  // namespace nav::bench
