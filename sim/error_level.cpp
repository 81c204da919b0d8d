// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/error_level.hpp"

#include "sim/named_kind.hpp"

namespace nav::sim {

const char* to_string(ErrorLevel level) {
  constexpr std::array<const char*, kErrorLevels.size()> kNames{"ideal", "good", "usual", "poor"};
  return kNames[static_cast<std::size_t>(level)];
}

Result<ErrorLevel> error_level_from(std::string_view name) {
  return kind_by_name(
      "level", {ErrorLevel::kIdeal, ErrorLevel::kGood, ErrorLevel::kUsual, ErrorLevel::kPoor},
      name);
}

LevelErrors errors_of(ErrorLevel level) {
  constexpr std::array<LevelErrors, kErrorLevels.size()> kErrors{{
      {.tracker_mm = 0.05,
       .calibration_mm = 0,
       .calibration_rad = 0,
       .delay_ms = 0,
       .sound_speed = 1,
       .layered_speed = false,
       .noise_level_db = -104,
       .tgc_error_db = 2,
       .clutter_level_db = -300,
       .reverberation = 0,
       .gas_haze_db = -300,
       .persistence = 0,
       .pressure_mm = 0,
       .unevenness = 0.3},
      {.tracker_mm = 0.2,
       .calibration_mm = 0.3,
       .calibration_rad = 0.003,
       .delay_ms = 10,
       .sound_speed = 1,
       .layered_speed = true,
       .noise_level_db = -98,
       .tgc_error_db = 3,
       .clutter_level_db = -50,
       .reverberation = 0.05,
       .gas_haze_db = -40,
       .persistence = 0.1,
       .pressure_mm = 2,
       .unevenness = 0.5},
      {.tracker_mm = 0.35,
       .calibration_mm = 0.6,
       .calibration_rad = 0.006,
       .delay_ms = 40,
       .sound_speed = 1.01,
       .layered_speed = true,
       .noise_level_db = -92,
       .tgc_error_db = 4,
       .clutter_level_db = -40,
       .reverberation = 0.1,
       .gas_haze_db = -30,
       .persistence = 0.2,
       .pressure_mm = 4,
       .unevenness = 0.6},
      {.tracker_mm = 0.5,
       .calibration_mm = 1.0,
       .calibration_rad = 0.01,
       .delay_ms = 80,
       .sound_speed = 1.02,
       .layered_speed = true,
       .noise_level_db = -86,
       .tgc_error_db = 6,
       .clutter_level_db = -35,
       .reverberation = 0.2,
       .gas_haze_db = -25,
       .persistence = 0.3,
       .pressure_mm = 8,
       .unevenness = 0.7},
  }};
  return kErrors[static_cast<std::size_t>(level)];
}

void set_image_errors(const LevelErrors& errors, ProbeModel& probe) {
  probe.noise_level_db = errors.noise_level_db;
  probe.tgc_error_db = errors.tgc_error_db;
  probe.clutter_level_db = errors.clutter_level_db;
  probe.reverberation = errors.reverberation;
  probe.gas_haze_db = errors.gas_haze_db;
  probe.persistence = errors.persistence;
  probe.layered_speed = errors.layered_speed;
  probe.sound_speed = errors.sound_speed;
}

}  // namespace nav::sim
