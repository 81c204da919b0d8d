// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"
#include "nav/time.hpp"

namespace nav::sim {

/// How a simulated tracker errs. Noise is white, per axis, one standard deviation.
struct TrackerModel {
  double rate_hz = 50;
  double noise_mm = 0.15;
  double noise_rad = 0.0015;
  Duration latency = std::chrono::milliseconds(15);  ///< acquired to received.
  Duration jitter = std::chrono::milliseconds(2);    ///< Added latency, uniform in [0, jitter].
  double dropout_probability = 0;                    ///< That an occlusion begins at a sample.
  int dropout_samples = 10;                          ///< Length of an occlusion.
};

/// A tracker streams from so long before the first picture until so long after the last.
inline constexpr Duration kTrackerLeadIn = std::chrono::milliseconds(500);

/// Stamps of simulated pictures.
struct ImageTiming {
  Duration stamp_offset{0};  ///< Stamped acquisition minus physical acquisition: what the pairing
                             ///< has to correct.
  Duration latency = std::chrono::milliseconds(30);  ///< Physical acquisition to received.
};

/// A refusal that names the first value that cannot be.
Result<void> validate(const TrackerModel& model);

}  // namespace nav::sim
