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
  std::filesystem::path out;     ///< Folder of the pictures.
  /// snr, vesselness, confidence, gradient-magnitude, -angle, -along, -across, depth; none: all,
  /// without scan lines those that need none.
  std::vector<std::string> features;
  std::vector<double> into;     ///< Of parallel scan lines, away from the probe, LPS: 3 numbers.
  std::vector<double> apex_mm;  ///< Of a fan instead, LPS: 3 numbers.
  std::vector<double> face_mm;  ///< Where parallel lines have depth 0; none: the nearest voxel.
  double face_radius_mm = 0;    ///< Of the fan's probe.
  std::filesystem::path scan_lines;  ///< File of a sweep's planes; instead.
  double smoothing_mm = render::features::kUsualSmoothingMm;  ///< Of gradients.
  double black = 0;  ///< Stored values; gradients are of shares of white.
  double white = 255;
  render::features::SnrOptions snr{};
  render::features::ConfidenceOptions confidence{};
  double smallest_radius_mm = 0.8;
  double largest_radius_mm = 3.0;
  bool bright_vessels = false;
  std::optional<int> unknown;   ///< Value of voxels that no picture reached, 16 bits; absent: none.
  int threads = 0;              ///< 0: all cores.
  std::filesystem::path cache;  ///< Folder of derived features; empty: none is kept.
};

/// Computes the features that predicates read from an ultrasound volume, in their units, and writes
/// the middle slice of each along every axis as PNG, black at the 1st and white at the 99th
/// percentile; blue where a feature is undefined. Prints ranges and times, and shows how far it is;
/// Ctrl-C ends it (kCancelled).
Result<void> run_derive(const DeriveOptions& options, Console& console);

}  // namespace nav::app
