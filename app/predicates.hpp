// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>

#include "app/console.hpp"
#include "nav/result.hpp"

namespace nav::app {

struct PredicatesOptions {
  std::filesystem::path volume;               ///< 3D ultrasound; empty: the neck phantom.
  std::filesystem::path out;                  ///< PNG.
  std::string predicates = "carotid-vessel";  ///< Name of a preset, or a file.
  double black = 0;                           ///< Stored values.
  double white = 255;
  std::optional<double> opacity_length_mm;  ///< Absent: what the set-up says.
  std::optional<Eigen::Vector3d> into_ct;   ///< Parallel scan lines, LPS; absent: along j.
  std::optional<Eigen::Vector3d> apex_ct;   ///< Of a fan, LPS mm; instead.
  double face_radius_mm = 0;                ///< Of the fan's probe.
  double smoothing_mm = 0.4;                ///< Of gradients.
  double smallest_radius_mm = 0.8;          ///< Of vessels, for vesselness.
  double largest_radius_mm = 3;
  bool bright_vessels = false;  ///< Brighter than what surrounds them.
  int width = 640;              ///< Of each half, pixels, [200, 4096].
  int height = 480;
};

/// Comparison mode: one picture with the standard rendering of a volume, by a grey transfer
/// function of the same opacities, beside its rendering by predicates, and the predicate histogram
/// below.
Result<void> run_predicates(const PredicatesOptions& options, Console& console);

}  // namespace nav::app
