// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/probe_model.hpp"

#include <cmath>
#include <numbers>
#include <sstream>
#include <string>

namespace nav::sim {

ProbeModel convex_abdominal() {
  ProbeModel probe;
  probe.half_angle_rad = 33.0 * std::numbers::pi / 180.0;
  return probe;
}

ProbeModel linear_l14() {
  ProbeModel probe;
  probe.kind = ProbeKind::kLinear;
  probe.width_mm = 38;
  probe.depth_mm = 60;
  probe.frequency_mhz = 9;
  probe.columns = 300;
  probe.rows = 460;
  probe.lines = 192;
  probe.focus_mm = 25;
  probe.lateral_fwhm_mm = 0.5;
  probe.elevation_fwhm_mm = 1.5;
  return probe;
}

ProbeModel sector_cranial() {
  ProbeModel probe;
  probe.kind = ProbeKind::kSector;
  probe.half_angle_rad = 40.0 * std::numbers::pi / 180.0;
  probe.depth_mm = 100;
  probe.frequency_mhz = 5;
  probe.focus_mm = 50;
  probe.lateral_fwhm_mm = 1.4;
  probe.elevation_fwhm_mm = 2.2;
  return probe;
}

Result<ProbeModel> probe_model_from(std::string_view name) {
  if (name == "convex") return convex_abdominal();
  if (name == "linear") return linear_l14();
  if (name == "sector") return sector_cranial();
  return Error{ErrorCode::kUsage,
               "probe: expected convex, linear or sector, found " + std::string(name)};
}

Result<AcousticModel> acoustic_model_from(std::string_view name) {
  if (name == "rays") return AcousticModel::kRays;
  if (name == "scatterers") return AcousticModel::kScatterers;
  return Error{ErrorCode::kUsage,
               "acoustic model: expected rays or scatterers, found " + std::string(name)};
}

double beside_probe_mm(const ProbeModel& probe) {
  constexpr double kBesideMm = 6;
  switch (probe.kind) {
    case ProbeKind::kLinear:
      return 0.5 * probe.width_mm + kBesideMm;
    case ProbeKind::kConvex:
      return probe.radius_mm * std::sin(probe.half_angle_rad) + kBesideMm;
    case ProbeKind::kSector:
      break;
  }
  constexpr double kSmallFaceMm = 10;
  return kSmallFaceMm + kBesideMm;
}

Result<void> validate(const ProbeModel& probe) {
  struct Range {
    const char* name;
    double value, low, high;
  };
  const Range ranges[] = {
      {"width_mm", probe.width_mm, 5, 300},
      {"radius_mm", probe.radius_mm, 5, 200},
      {"half_angle_rad", probe.half_angle_rad, 0.05, 1.4},
      {"depth_mm", probe.depth_mm, 10, 400},
      {"frequency_mhz", probe.frequency_mhz, 1, 20},
      {"columns", static_cast<double>(probe.columns), 16, 4096},
      {"rows", static_cast<double>(probe.rows), 16, 4096},
      {"lines", static_cast<double>(probe.lines), 8, 2048},
      {"focus_mm", probe.focus_mm, 1, 400},
      {"lateral_fwhm_mm", probe.lateral_fwhm_mm, 0.05, 20},
      {"elevation_fwhm_mm", probe.elevation_fwhm_mm, 0.05, 20},
      {"dynamic_range_db", probe.dynamic_range_db, 10, 120},
      {"liver_level_db", probe.liver_level_db, -120, 0},
      {"noise_level_db", probe.noise_level_db, -300, 0},
      {"tgc_db_per_cm_mhz", probe.tgc_db_per_cm_mhz, 0, 3},
      {"tgc_error_db", probe.tgc_error_db, 0, 30},
      {"gain_db", probe.gain_db, -60, 60},
      {"clutter_level_db", probe.clutter_level_db, -300, 0},
      {"clutter_mm", probe.clutter_mm, 1, 200},
      {"reverberation", probe.reverberation, 0, 0.95},
      {"gas_haze_db", probe.gas_haze_db, -300, 0},
      {"sound_speed", probe.sound_speed, 0.9, 1.1},
      {"looks", static_cast<double>(probe.looks), 1, 16},
      {"persistence", probe.persistence, 0, 0.95},
      {"stand_off_mm", probe.stand_off_mm, 0, 40},
  };
  for (const Range& r : ranges) {
    if (r.value >= r.low && r.value <= r.high) continue;
    std::ostringstream text;
    text << "simulated probe: expected " << r.name << " in [" << r.low << ", " << r.high
         << "], found " << r.value;
    return Error{ErrorCode::kUsage, text.str()};
  }
  return {};
}

}  // namespace nav::sim
