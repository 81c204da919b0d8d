// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "nav/result.hpp"
#include "render/features/confidence.hpp"
#include "render/features/gradient.hpp"
#include "render/features/snr.hpp"

namespace nav::app {

struct DeriveOptions {
  std::filesystem::path volume;  ///< DICOM folder, NIfTI, MetaImage or NRRD.
  std::filesystem::path out;     ///< Folder of the images.
  /// Names: snr, vesselness, confidence, gradient-magnitude, -angle, -along, -across, depth. Empty:
  /// all features; without scan lines only those that need none.
  std::vector<std::string> features;
  /// Direction of parallel scan lines away from the probe, LPS: 3 numbers, or empty.
  std::vector<double> into;
  std::vector<double> apex_mm;  ///< Apex of a fan, LPS: 3 numbers; instead of into.
  /// Point where parallel scan lines have depth 0, LPS: 3 numbers; empty: the nearest voxel.
  std::vector<double> face_mm;
  double face_radius_mm = 0;         ///< Radius of the fan's probe.
  std::filesystem::path scan_lines;  ///< File of a sweep's planes; instead of into or apex_mm.
  double smoothing_mm = render::features::kUsualSmoothingMm;  ///< Smoothing of gradients.
  /// Stored values of black and white; gradients are in shares of white per mm.
  double black = 0;
  double white = 255;
  render::features::SnrOptions snr{};
  render::features::ConfidenceOptions confidence{};
  double smallest_radius_mm = 0.8;
  double largest_radius_mm = 3.0;
  bool bright_vessels = false;
  std::optional<int> unknown;   ///< Value of voxels that no image reached, 16 bits; absent: none.
  int size_px = 512;            ///< Longer side of each image.
  int threads = 0;              ///< 0: all cores.
  std::filesystem::path cache;  ///< Folder of derived features; empty: no cache.
};

/// Computes the features that predicates read from an ultrasound volume, and writes the middle
/// slice of each across every axis as PNG, with letters, scale bar, position and range: black at
/// the 1st percentile, white at the 99th, blue where a feature is undefined. Prints ranges, in the
/// features' units, and times, and shows its progress. Ctrl-C ends it (kCancelled).
Result<void> run_derive(const DeriveOptions& options, Console& console);

}  // namespace nav::app
