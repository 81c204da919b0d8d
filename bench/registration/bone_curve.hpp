// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/registration/bone_scene.hpp"

/// Detection of bone and registration by it on simulated sweeps.
namespace nav::bench {

struct BoneCurveOptions {
  std::uint64_t first_seed = 1;
  int sweeps = 4;   ///< Number for each site and level, >= 1.
  int images = 30;  ///< Images in a sweep, >= 2.
  std::vector<ErrorLevel> levels{kErrorLevels.begin(), kErrorLevels.end()};
  double start_mm = 15;
  double start_rad = 0.175;
};

/// One site at one level of errors.
struct BoneFinding {
  BoneSite site;
  ErrorLevel level;
  // Detection, over all scan lines.
  int with_bone = 0;                      ///< Lines that meet bone.
  int found = 0;                          ///< Lines of these whose bone is found within 2 mm.
  int far = 0;                            ///< Echoes farther than 2 mm from the line's bone.
  int without_bone = 0;                   ///< Echoes on lines without bone.
  std::vector<double> depth_errors_mm{};  ///< Found less true depth, where within 2 mm.
  double detect_ms = 0;                   ///< Processor time of an image.
  // Registration from the start.
  int runs = 0, accepted = 0, wrong_accepted = 0, undetermined = 0;
  std::vector<double> errors_mm{};  ///< RMS of the echoes from where they belong, determined runs.
  /// Registrations to the mirrored CT from near the truth, and those that were accepted.
  int mirrored = 0, mirrored_accepted = 0;
};

/// Runs every site at every level. Errors: those of the simulator.
Result<std::vector<BoneFinding>> measure_bones(const BoneCurveOptions& options,
                                               const std::function<void(double)>& progress);

std::string to_text(const std::vector<BoneFinding>& findings);

}  // namespace nav::bench
