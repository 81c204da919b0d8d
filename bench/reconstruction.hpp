// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/measure.hpp"

namespace nav::bench {

struct ReconstructionBenchOptions {
  bool quick = false;  ///< Few and small images, coarse voxels.
  int threads = 0;     ///< 0: all cores.
  /// Parts to measure.
  bool rates = true, backward = true, errors = true;
};

/// Rate of images of one method into a volume of fixed size.
struct ReconstructionRate {
  std::string method, compound;
  int images = 0;
  double fps_p50 = 0, fps_p95 = 0;  ///< Half, and 95 %, of the images are as fast or faster.
  double cpu_ms = 0;                ///< Process time of one image, mean.
};

/// The backward method, images and voxels together.
struct BackwardTime {
  int images = 0, width = 0, height = 0;
  double spacing_mm = 0;
  std::size_t voxels = 0, seen = 0;
  Taken taken{};
};

/// Difference between images of the simulator that were left out and the volume of the others.
struct ReconstructionErrorPoint {
  std::string method, compound;
  double spacing_mm = 0;
  double covered = 0;         ///< Share of the pixels around which all eight voxels are seen.
  double rms = 0, mean = 0;   ///< Grey levels, over the covered pixels; mean of volume minus truth.
  double rms_everywhere = 0;  ///< Over the pixels that every method covers at this spacing.
  double seconds = 0;         ///< Wall time of all images and voxels.
};

struct ReconstructionBenchReport {
  int width = 0, height = 0, side = 0;  ///< Images and volume of the rates.
  std::vector<ReconstructionRate> rates;
  std::optional<BackwardTime> backward;
  double image_distance_mm = 0;  ///< Between images that are reconstructed, median.
  /// Grey levels between an image that was left out and the one before it: no volume at all.
  double neighbour_rms = 0;
  std::vector<ReconstructionErrorPoint> errors;
};

/// progress: fraction done, [0, 1].
Result<ReconstructionBenchReport> measure_reconstruction(
    const ReconstructionBenchOptions& options, const std::function<void(double)>& progress);

/// Plain-text table.
std::string to_text(const ReconstructionBenchReport& report);

}  // namespace nav::bench
