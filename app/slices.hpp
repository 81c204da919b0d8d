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

struct SlicesOptions {
  std::filesystem::path ct;
  std::filesystem::path out;
  bool accept_unknown_orientation = false;
  std::optional<Eigen::Vector3d> at_ct;  ///< LPS mm; absent: the middle of the CT.
  double slab_mm = 0;
  std::string slab = "maximum";  ///< Or minimum, mean.
  double level_hu = 60;
  double width_hu = 400;
  int size_px = 512;        ///< Of each picture, both sides.
  double mm_per_pixel = 0;  ///< 0: the CT fits.
};

/// Writes axial.png, coronal.png and sagittal.png through a point, with the letters of the
/// directions at their edges. Refuses options out of range by name.
Result<void> run_slices(const SlicesOptions& options, Console& console);

}  // namespace nav::app
