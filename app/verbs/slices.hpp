// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "app/console.hpp"
#include "app/options/session_config.hpp"
#include "nav/result.hpp"

namespace nav::app {

struct SlicesOptions {
  /// Point of the axial, coronal, sagittal and oblique slice, LPS mm. Absent: the middle of the
  /// ultrasound picture, the needle's tip, the plan's target, or the middle of the CT, whichever
  /// there is first.
  std::optional<Eigen::Vector3d> at_ct;
  std::optional<Eigen::Vector3d> normal_ct;  ///< Of an oblique slice, LPS; of any length and sign.
  std::optional<Eigen::Vector3d> right_ct;   ///< Instead: its direction to the right, LPS,
  std::optional<Eigen::Vector3d> down_ct;    ///< and one down, made square to right in the plane.
  std::optional<Eigen::Matrix<double, 6, 1>> needle_ct;  ///< Tip and hub, LPS mm.
  double slab_mm = 0;
  std::string slab = "maximum";  ///< Or minimum, mean.
  int size_px = 512;             ///< Of each picture, both sides.
  double mm_per_pixel = 0;       ///< 0: the CT fits; along the ultrasound picture that does.

  std::optional<std::int64_t> frame;   ///< Of the recording, from 0; absent: the middle one.
  std::filesystem::path second;        ///< Volume in the CT's frame, fused with it; empty: none.
  std::optional<double> second_level;  ///< Its own values; absent, as the width: its value range.
  std::optional<double> second_width;
  std::string fusion = "blend";  ///< Or checkerboard, wipe.
  double share = 0.5;            ///< Of the picture or second volume, [0, 1].
  double square_mm = 10;
  double wipe = 0.5;  ///< Share of the width, [0, 1].
};

/// Writes axial.png, coronal.png and sagittal.png of the session's CT through a point into the
/// session's output folder, with the letters of the directions at their edges; where they are asked
/// for oblique.png, needle-1.png and needle-2.png (along the needle, at right angles), of a session
/// with a plan path-1.png and path-2.png (along its path), and ultrasound.png (along a picture of
/// the session's recording, placed as a replay places it), all fused with that picture or the
/// second volume. Refuses by name what is missing or out of range, the simulated procedure, points
/// outside the CT, and frames without a pose.
Result<void> run_slices(const SessionConfig& config, const SlicesOptions& options,
                        Console& console);

}  // namespace nav::app
