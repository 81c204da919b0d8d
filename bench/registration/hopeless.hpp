// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/registration/cohort.hpp"

namespace nav::bench {

/// Inputs for which no registration can or may be right.
enum class Hopeless {
  kWrongPatient,  ///< The CT of another patient, at the position of the patient's own CT.
  kMirrored,      ///< Images flipped left to right: the probe's marker on the wrong side.
  kWrongScale,    ///< Pixel size stated a fifth larger than it is.
  kAllShadow,     ///< Echoes of the first 25 mm only, followed by noise.
  kSaturated,     ///< Gain so high that nearly everything is white.
  kTinyOverlap,   ///< A CT that ends where the sweep begins: it contains an eighth of the sweep.
  kTurned,        ///< A start rotated by 180 degrees.
};
inline constexpr int kHopelessKinds = 7;
const char* to_string(Hopeless kind);

/// Target error of the starts; kTurned has none besides the rotation.
inline constexpr double kHopelessStartMm = 5;

/// A case as the registration receives it.
struct HopelessCase {
  std::shared_ptr<const Volume> ct;
  Sweep sweep;
  CtPose start;
  /// False: accepting any result is wrong. True: a result is right if its target error is small.
  bool may_be_right;
};

/// other: the patient whose CT is confused with the patient's own; the start has an error of a few
/// mm.
HopelessCase make_hopeless(Hopeless kind, const Patient& patient, const Patient& other,
                           const RecordedSweep& recorded, std::uint64_t seed);

}  // namespace nav::bench
