// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "sim/motion/breathing.hpp"
#include "sim/probe_model.hpp"

namespace nav::bench {

/// A setting of the live registration: time of an update against error. Errors are those of the
/// pose at the places of a picture, RMS, against where the CT has what it shows; of pictures that
/// are shown as valid.
struct LivePoint {
  sim::BreathingKind kind;
  int window;
  int patches;          ///< Of a picture.
  int trials;           ///< Patients.
  double shown;         ///< Share of all pictures.
  double still_mm;      ///< RMS over a patient's pictures at the accepted pose, median of patients.
  double following_mm;  ///< The same of the pose that follows.
  double p95_mm;        ///< 95th percentile over all pictures, of the pose that follows.
  double predicted_mm;  ///< What it says of itself, median over all pictures.
  double update_cpu_ms;  ///< Median processor time, one thread.
};

/// Whose CT it is: all patients' pictures with their own CT and with those of the others.
struct LiveEvidence {
  int own = 0;
  int own_withdrawn = 0;  ///< For not matching better where it lies; not: for a time lost.
  int others = 0;
  int others_withdrawn = 0;
  double pictures_median = 0;  ///< Until another's is withdrawn; NaN without.
};

struct LiveCurve {
  std::vector<LivePoint> points;
  LiveEvidence evidence;
};

struct LiveCurveOptions {
  std::uint64_t first_seed = 1;
  int patients = 4;
  sim::AcousticModel model = sim::AcousticModel::kRays;
  std::vector<sim::BreathingKind> kinds{sim::BreathingKind::kNone, sim::BreathingKind::kRigid,
                                        sim::BreathingKind::kSmooth};
  double breathing_mm = 10;  ///< Towards the feet, mean.
  double duration_s = 8;
  double frame_rate_hz = 15;
  std::vector<int> windows{1, 3, 6};        ///< With the usual patches.
  std::vector<int> patches{100, 300, 900};  ///< With the usual window.
};

/// Sweeps of patients who breathe, followed from the true pose at the end of expiration. Evidence:
/// with the last of the kinds. Errors: those of the simulator and of LiveRegistration.
Result<LiveCurve> measure_live(const LiveCurveOptions& options,
                               const std::function<void(double)>& progress = {});

std::string to_text(const LiveCurve& curve);

}  // namespace nav::bench
