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
  int side = 256;  ///< Of the timed volume, voxels, [32, 512].
  Repeats repeats{3, 30};
  int threads = 0;  ///< 0: all cores.
  /// Of the volume that confidence is held against its definition on, whose time grows with the
  /// sixth power, voxels, [16, 32].
  int confidence_side = 28;
  /// Those of DerivedTiming and depth; empty: all.
  std::vector<std::string> features{};
};

/// One feature on the timed volume.
struct DerivedTiming {
  /// snr, vesselness, confidence, confidence_of_fan (whose scan lines meet above the volume),
  /// gradient_magnitude, gradient_angle, and smoothed by 0.4 mm: smooth_gradient_magnitude, _along,
  /// _across.
  std::string feature;
  Taken taken;
  double goal_s = 0;           ///< Wall, 256^3, two cores; NaN: none set.
  double bytes_per_voxel = 0;  ///< Resident at most, above what was before.
  std::string note;            ///< What the computation says of itself.
  std::string peer;            ///< Filter of ITK; "none": it has none; "not built".
  Taken peer_taken;            ///< On the same voxels, as many threads; NaN without a peer.
  [[nodiscard]] double ratio() const { return peer_taken.cpu_s / taken.cpu_s; }
};

/// Run time against error on a volume small enough for the double definition: over whatever turns
/// the one into the other, and where the computation has no such thing, over the size of the
/// volume.
struct DerivedErrorPoint {
  std::string feature;  ///< As above, and depth.
  std::string setting;  ///< What was turned, and how far.
  double cpu_s = 0;
  double rms = 0, max = 0;  ///< Against the double definition, in units of the feature.
  double median_value = 0;  ///< Of the definition's magnitude: the scale of the errors.
};

struct DerivedBenchReport {
  int side = 0;
  std::vector<DerivedTiming> timings;
  std::vector<DerivedErrorPoint> errors;
};

/// Whole-number intensities of 0 to 255: Rayleigh speckle that is correlated over a few voxels, in
/// layers, with three dark vessels and the shadow of a bone; scan lines run along +j. side voxels
/// of 0.4 mm along each axis. The same for every run.
render::features::ScalarVolume derived_phantom(int side);

/// progress: share done, [0, 1].
Result<DerivedBenchReport> measure_derived(const DerivedBenchOptions& options,
                                           const std::function<void(double)>& progress);

/// A table for people.
std::string to_text(const DerivedBenchReport& report);

}  // namespace nav::bench
