// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

#include "nav/result.hpp"
#include "sim/probe_model.hpp"

namespace nav::sim {

/// Imperfection of tracker, calibration and scanner, as a whole.
enum class ErrorLevel { kIdeal, kGood, kUsual, kPoor };
inline constexpr std::array<ErrorLevel, 4> kErrorLevels{ErrorLevel::kIdeal, ErrorLevel::kGood,
                                                        ErrorLevel::kUsual, ErrorLevel::kPoor};
/// Stable lower-case name: "ideal", "good", "usual", "poor"; and its inverse, kUsage for others.
const char* to_string(ErrorLevel level);
Result<ErrorLevel> error_level_from(std::string_view name);

/// The figures of a level.
struct LevelErrors {
  double tracker_mm;      ///< Standard deviation per axis; 0.01 rad for each mm about each axis.
  double calibration_mm;  ///< Length of the shift of the images, in a seeded direction.
  double calibration_rad;
  double delay_ms;          ///< Delay of the images relative to their poses.
  double sound_speed;       ///< Speed that the scanner assumes over the usual 1540 m/s.
  bool layered_speed;       ///< Every tissue has its own speed of sound.
  double noise_level_db;    ///< Before the depth gain, which lifts it at depth.
  double tgc_error_db;      ///< Peak error of the depth gain.
  double clutter_level_db;  ///< Haze at the face; -300: none.
  double reverberation;     ///< Amplitude reflected by the face.
  double gas_haze_db;       ///< Haze below gas; -300: none.
  double persistence;       ///< Share of the last image in the next one.
  double pressure_mm;       ///< Displacement of the tissue under the probe.
  double unevenness;        ///< Pace of the hand.
};
LevelErrors errors_of(ErrorLevel level);

/// Gives a probe the image errors of a level: noise, depth gain, haze, reverberation, persistence,
/// speed of sound by tissue.
void set_image_errors(const LevelErrors& errors, ProbeModel& probe);

}  // namespace nav::sim
