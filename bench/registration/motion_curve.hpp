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

/// Setting of the refinement of sweeps of breathing patients: run time against error at rest.
struct MotionPoint {
  sim::BreathingKind kind;
  int images = 0;  ///< Evenly chosen images of the sweep.
  int harmonics;
  int trials = 0;
  int supported = 0;     ///< Trials in which the images support a motion.
  double common_mm = 0;  ///< Median error of the common pose at the targets, RMS for each trial.
  /// Median error of the pose at rest, over the supported; NaN if there are none.
  double error_median_mm = 0;
  double error_worst_mm = 0;
  /// Median processor time of register_moving(), including its preparation.
  double motion_cpu_s = 0;
  double motion_wall_s = 0;  ///< Median wall time of the same.
};

struct MotionCurveOptions {
  std::uint64_t first_seed = 1;
  int patients = 2;
  sim::AcousticModel model = sim::AcousticModel::kRays;
  std::vector<sim::BreathingKind> kinds{sim::BreathingKind::kRigid, sim::BreathingKind::kAffine,
                                        sim::BreathingKind::kSmooth};
  double breathing_mm = 8;  ///< Mean motion towards the feet.
  double period_s = 4;
  double duration_s = 16;
  double frame_rate_hz = 15;
  std::vector<int> image_strides{4, 2, 1};  ///< With the default harmonics.
  std::vector<int> harmonics{1, 2, 3};      ///< With the last of the strides.
  int threads = 2;
};

/// Registers a common pose from an error of 5 mm, then the motion with the breath by its mean
/// period.
/// Errors: those of the simulator, register_sweep() and register_moving().
Result<std::vector<MotionPoint>> measure_motion(const MotionCurveOptions& options,
                                                const std::function<void(double)>& progress = {});

std::string to_text(const std::vector<MotionPoint>& points);

}  // namespace nav::bench
