// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "nav/result.hpp"

namespace nav::sim {

/// What a point of the simulated patient consists of.
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
  kVesselWall,  ///< Acoustic values: media.
  kPlaque,      ///< Soft.
  kCalcification,
  kThyroid,
  kNerve,
  kTendon,
  kFascia,  ///< Sheaths of muscle and tendon, paratenon, bursal fat.
  kFluid,   ///< Bursa, joint, tear.
  kGreyMatter,
  kWhiteMatter,
  kCerebrospinalFluid,
  kDura,
  kTumour,  ///< Of the brain.
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
  kMr  ///< Not a CT: T1-weighted-like grey values, 0 to 1000, of no unit.
};

/// Stable lower-case name ("portal"), and back; kUsage for a name that is none.
const char* to_string(Contrast contrast);
Result<Contrast> contrast_from(std::string_view name);

/// Mean CT value of a tissue in a contrast phase, HU (kMr: grey value). Typical textbook values.
double tissue_hu(Tissue tissue, Contrast contrast);

/// Acoustic values of a tissue, chosen independently of its CT value (bile and blood, liver and
/// spleen, fat and lesion order differently in the two pictures).
struct Acoustics {
  float impedance_mrayl;            ///< Density times speed of sound, MRayl.
  float attenuation_db_per_cm_mhz;  ///< One way, dB / (cm MHz).
  float scatter;                    ///< Backscatter amplitude relative to liver, >= 0.
  /// Direction of fibres, CT axes, as long as the share of the scatter that they direct, [0, 1].
  std::array<float, 3> fibre{};
  /// Backscatter amplitude of a thin layer, relative to liver, along its unit normal, CT axes:
  /// comes on top of scatter, strongest where the beam meets the layer square.
  std::array<float, 3> sheet{};
};
const Acoustics& tissue_acoustics(Tissue tissue);

/// Bone and gas: they end a scan line.
bool blocks_ultrasound(Tissue tissue);

}  // namespace nav::sim
