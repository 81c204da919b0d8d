// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/registration/cohort.hpp"

namespace nav::bench {

/// Inputs that no registration can or may be right on.
enum class Hopeless {
  kWrongPatient,  ///< The CT of another patient, laid where the own one would lie.
  kMirrored,      ///< Pictures flipped left to right: the probe's marker on the wrong side.
  kWrongScale,    ///< Pixels that claim to be a fifth larger than they are.
  kAllShadow,     ///< Echoes of the first 25 mm only, then noise.
  kSaturated,     ///< Gain so high that nearly everything is white.
  kTinyOverlap,   ///< A CT that ends where the sweep begins: an eighth of it is seen.
  kTurned,        ///< A start that is 180 degrees off.
};
inline constexpr int kHopelessKinds = 7;
const char* to_string(Hopeless kind);

/// Target error of their starts; of kTurned, besides the turn, none.
inline constexpr double kHopelessStartMm = 5;

/// A case as the registration gets it.
struct HopelessCase {
  std::shared_ptr<const Volume> ct;
  Sweep sweep;
  CtPose start;
  /// False: whatever is found, accepting it is wrong. True: right when the target error is small.
  bool may_be_right;
};

/// other: the patient whose CT is confused with the own one; the start is off by a few mm.
HopelessCase make_hopeless(Hopeless kind, const Patient& patient, const Patient& other,
                           const RecordedSweep& recorded, std::uint64_t seed);

}  // namespace nav::bench
