// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/measure.hpp"
#include "render/features/volume.hpp"

namespace nav::bench {

struct DerivedBenchOptions {
  int side = 256;  ///< Side of the timed volume, voxels, [32, 512].
  Repeats repeats{3, 30};
  int threads = 0;  ///< 0: all cores.
  /// Side of the volume on which confidence is compared with its definition, whose time grows with
  /// the sixth power, voxels, [16, 32].
  int confidence_side = 28;
  /// Features to measure: those of DerivedTiming, and depth; empty: all.
  std::vector<std::string> features{};
};

/// Time of one feature on the timed volume.
struct DerivedTiming {
  /// snr, vesselness, confidence, confidence_of_fan (its scan lines meet above the volume),
  /// gradient_magnitude, gradient_angle, and smoothed by 0.4 mm: smooth_gradient_magnitude, _along,
  /// _across.
  std::string feature;
  Taken taken{};
  double goal_s = 0;           ///< Wall time, 256^3, two cores; NaN: no goal.
  double bytes_per_voxel = 0;  ///< Largest increase of resident memory.
  std::string note{};          ///< Remark of the computation about itself.
  std::string peer;            ///< Filter of ITK; "none": ITK has no such filter; "not built".
  Taken peer_taken;            ///< On the same voxels with as many threads; NaN without a peer.
  [[nodiscard]] double ratio() const { return peer_taken.cpu_s / taken.cpu_s; }
};

/// Run time against error on a volume that is small enough for the definition in double precision.
/// The setting that trades time for error is varied; for a computation without one, the size of the
/// volume is.
struct DerivedErrorPoint {
  std::string feature;  ///< See DerivedTiming, and depth.
  std::string setting;  ///< Varied setting and its value.
  double cpu_s = 0;
  /// Against the definition in double precision, in units of the feature.
  double rms = 0, max = 0;
  double median_value = 0;  ///< Median magnitude of the definition: the scale of the errors.
};

struct DerivedBenchReport {
  int side = 0;
  std::vector<DerivedTiming> timings;
  std::vector<DerivedErrorPoint> errors;
};

/// Whole-number intensities of 0 to 255: Rayleigh speckle that is correlated over a few voxels, in
/// layers, with three dark vessels and the shadow of a bone; scan lines run along +j. side voxels
/// of 0.4 mm along each axis. Every run gives the same volume.
render::features::ScalarVolume derived_phantom(int side);

/// progress: fraction done, [0, 1].
Result<DerivedBenchReport> measure_derived(const DerivedBenchOptions& options,
                                           const std::function<void(double)>& progress);

/// Plain-text table.
std::string to_text(const DerivedBenchReport& report);

}  // namespace nav::bench
