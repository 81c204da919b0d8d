// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>

#include "app/console.hpp"
#include "app/options/session_config.hpp"
#include "nav/result.hpp"

namespace nav::app {

struct ReconstructOptions {
  std::filesystem::path out;         ///< MetaImage to write.
  std::string method = "nearest";    ///< nearest, trilinear, gaussian, backward.
  std::string compound = "mean";     ///< mean, median, max, latest.
  std::optional<double> spacing_mm;  ///< Absent: the configuration's, otherwise 0.5.
  int fill = 0;                      ///< Longest hole that is filled, voxels; 0: none.
  /// Column, row, width, height; absent: the configuration's.
  std::optional<Eigen::Vector4d> clip_px;
  /// Two angles (degrees), column and row of the origin, two radii (pixels); absent: the
  /// configuration's.
  std::optional<Eigen::Matrix<double, 6, 1>> fan;
  std::string weights = "none";  ///< none, confidence.
  double gaussian_voxels = 0.5;
  std::optional<double> reach_mm;  ///< Absent: the voxels' side.
  int threads = 0;                 ///< 0: all cores.
};

/// Reconstructs a volume of the images of a recording in its Reference frame, and writes it with
/// its scan lines (backward) and the origin of its voxels (--fill) beside it. Shows its progress;
/// Ctrl-C ends it (kCancelled) and leaves no file. \p json: file of the report, absent: none.
Result<void> run_reconstruct(const SessionConfig& config, const ReconstructOptions& options,
                             const std::optional<std::string>& json, Console& console);

}  // namespace nav::app
