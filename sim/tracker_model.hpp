// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"
#include "nav/time.hpp"

namespace nav::sim {

/// Errors of a simulated tracker. Noise is white; each value is the standard deviation per axis.
struct TrackerModel {
  double rate_hz = 50;
  double noise_mm = 0.15;
  double noise_rad = 0.0015;
  Duration latency = std::chrono::milliseconds(15);  ///< Time from acquisition to reception.
  Duration jitter = std::chrono::milliseconds(2);    ///< Added latency, uniform in [0, jitter].
  double dropout_probability = 0;                    ///< Chance of an occlusion per sample.
  int dropout_samples = 10;                          ///< Length of an occlusion, samples.
};

/// Time before the first and after the last image during which a tracker also streams.
inline constexpr Duration kTrackerLeadIn = std::chrono::milliseconds(500);

/// Time stamps of simulated images.
struct ImageTiming {
  /// Stamped minus physical acquisition; the pairing has to correct it.
  Duration stamp_offset{0};
  Duration latency = std::chrono::milliseconds(30);  ///< Physical acquisition to reception.
};

/// Rejects an invalid model; the message names the first invalid value.
Result<void> validate(const TrackerModel& model);

}  // namespace nav::sim
