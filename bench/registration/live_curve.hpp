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

/// Setting of the live registration: time of an update against error. Errors compare the pose at
/// the positions of an image, RMS, with the true positions of its content in the CT; only images
/// that are shown as valid count.
struct LivePoint {
  sim::BreathingKind kind;
  int window;
  int patches;          ///< Patches of each image.
  int trials;           ///< Number of patients.
  double shown;         ///< Fraction of all images that are shown.
  double still_mm;      ///< RMS over a patient's images at the accepted pose, median over patients.
  double following_mm;  ///< RMS at the pose that follows, median over patients.
  double p95_mm;        ///< 95th percentile over all images, for the pose that follows.
  double predicted_mm;  ///< Error that it predicts itself, median over all images.
  double update_cpu_ms;  ///< Median processor time, one thread.
};

/// Test if the CT is that of the patient: all patients' images with their own CT and with those of
/// the others.
struct LiveEvidence {
  int own = 0;
  /// Withdrawn because they do not match better at the pose than elsewhere; being lost for a time
  /// does not count.
  int own_withdrawn = 0;
  int others = 0;
  int others_withdrawn = 0;
  double images_median = 0;  ///< Images until another patient's CT is withdrawn; NaN if none is.
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
  double breathing_mm = 10;  ///< Mean motion towards the feet.
  double duration_s = 8;
  double frame_rate_hz = 15;
  std::vector<int> windows{1, 3, 6};        ///< With the default patches.
  std::vector<int> patches{100, 300, 900};  ///< With the default window.
};

/// Follows sweeps of breathing patients from the true pose at the end of expiration. The evidence
/// is measured with the last of the kinds. Errors: those of the simulator and of LiveRegistration.
Result<LiveCurve> measure_live(const LiveCurveOptions& options,
                               const std::function<void(double)>& progress = {});

std::string to_text(const LiveCurve& curve);

}  // namespace nav::bench
