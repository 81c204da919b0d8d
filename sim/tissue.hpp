// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "nav/result.hpp"

namespace nav::sim {

/// Material at a point of the simulated patient.
enum class Tissue : std::uint8_t {
  kAir,  ///< Outside the patient.
  kSkin,
  kFat,
  kMuscle,
  kPeritonealFat,
  kBone,
  kMarrow,
  kDisc,
  kSpinalCanal,
  kCartilage,
  kLung,
  kDiaphragm,
  kLiver,
  kLesion,
  kHepaticVein,
  kPortalVein,
  kPortalWall,
  kAorta,
  kVenaCava,
  kGallbladderWall,
  kBile,
  kKidneyCortex,
  kKidneyMedulla,
  kRenalSinus,
  kSpleen,
  kBowelWall,
  kBowelContent,
  kGas,
  kArtery,      ///< Lumen of a large artery outside the abdomen.
  kVein,        ///< Lumen of a large vein outside the abdomen.
  kVesselWall,  ///< Acoustic values of the media.
  kPlaque,      ///< Soft plaque.
  kCalcification,
  kThyroid,
  kNerve,
  kTendon,
  kFascia,  ///< Sheaths of muscles and tendons, paratenon, bursal fat.
  kFluid,   ///< Fluid of a bursa, joint or tear.
  kGreyMatter,
  kWhiteMatter,
  kCerebrospinalFluid,
  kDura,
  kTumour,  ///< Brain tumour.
  kGel,     ///< Bath or pad that couples a probe.
  kCount
};

/// Stable lower-case name, for reports.
const char* to_string(Tissue tissue);

/// Contrast phase of the simulated CT.
enum class Contrast {
  kNative,
  kArterial,
  kPortal,
  kMr  ///< Not a CT: grey values like a T1-weighted MR, 0 to 1000, without unit.
};

/// Stable lower-case name ("portal"), and its inverse; kUsage for an unknown name.
const char* to_string(Contrast contrast);
Result<Contrast> contrast_from(std::string_view name);

/// Mean CT value of a tissue in a contrast phase, HU (kMr: grey value). Typical textbook values.
double tissue_hu(Tissue tissue, Contrast contrast);

/// Acoustic values of a tissue, chosen independently of its CT value. Bile and blood, liver and
/// spleen, and fat and lesion have a different order of brightness in CT and ultrasound.
struct Acoustics {
  float impedance_mrayl;            ///< Density times speed of sound, MRayl.
  float attenuation_db_per_cm_mhz;  ///< One way, dB / (cm MHz).
  float scatter;                    ///< Backscatter amplitude relative to liver, >= 0.
  /// Direction of fibres, CT axes. Its length is the share of the scatter that depends on this
  /// direction, [0, 1].
  std::array<float, 3> fibre{};
  /// Backscatter amplitude of a thin layer, relative to liver, along its unit normal, CT axes. It
  /// is added to scatter, and strongest where the beam is perpendicular to the layer.
  std::array<float, 3> sheet{};
};
const Acoustics& tissue_acoustics(Tissue tissue);

/// Speed of sound that scanners assume, m/s.
inline constexpr double kAssumedSoundSpeed = 1540;
/// Speed of sound of a tissue at body temperature, m/s. For bone and gas, behind which no echo is
/// shown at its own depth, the speed that scanners assume.
double sound_speed(Tissue tissue);

/// True for bone and gas, which end a scan line.
bool blocks_ultrasound(Tissue tissue);

}  // namespace nav::sim
