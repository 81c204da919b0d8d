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
  /// Point of the axial, coronal, sagittal and oblique slice, LPS mm. Absent: the first that exists
  /// of the middle of the ultrasound image, the needle's tip, the plan's target, and the middle of
  /// the CT.
  std::optional<Eigen::Vector3d> at_ct;
  /// Normal of an oblique slice, LPS; of any length > 0 and either sign.
  std::optional<Eigen::Vector3d> normal_ct;
  /// Directions of an oblique slice to the right and down, LPS; instead of normal_ct. down_ct is
  /// made perpendicular to right_ct.
  std::optional<Eigen::Vector3d> right_ct;
  std::optional<Eigen::Vector3d> down_ct;
  std::optional<Eigen::Matrix<double, 6, 1>> needle_ct;  ///< Tip and hub, LPS mm.
  double slab_mm = 0;                                    ///< Thickness of the slab.
  std::string slab = "maximum";                          ///< maximum, minimum or mean.
  int size_px = 512;                                     ///< Width and height of each image.
  /// Scale; 0: the whole CT fits, and the whole ultrasound image fits into the slice along it.
  double mm_per_pixel = 0;

  std::optional<std::int64_t> frame;  ///< Number of the image, from 0; absent: the middle one.
  std::filesystem::path second;       ///< Volume in the CT's frame, fused with it; empty: none.
  /// Grey window of the second volume, in its own values; absent: chosen from the shown values.
  std::optional<double> second_level;
  std::optional<double> second_width;
  std::string fusion = "blend";  ///< blend, checkerboard or wipe.
  double share = 0.5;            ///< Share of the ultrasound image or second volume, [0, 1].
  double square_mm = 10;
  double wipe = 0.5;  ///< Position of the edge as a share of the width, [0, 1].
};

/// Writes slices of the session's CT into the session's output folder, with the letters of the
/// patient's directions at their edges:
/// - axial.png, coronal.png and sagittal.png through a point;
/// - oblique.png, if the options give its plane;
/// - needle-1.png and needle-2.png along the needle, at right angles, if there is a needle;
/// - path-1.png and path-2.png along the plan's path, if the session has a plan;
/// - ultrasound.png along an image of the session's recording, placed as a replay places it.
/// All are fused with that image or with the second volume. Rejects, by name, options that are
/// missing or out of range, the simulated procedure, points outside the CT, and images without a
/// pose.
Result<void> run_slices(const SessionConfig& config, const SlicesOptions& options,
                        Console& console);

}  // namespace nav::app
