// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "bench/registration/cohort.hpp"
#include "nav/result.hpp"
#include "registration/bone/bone_detector.hpp"
#include "sim/anatomy/anatomy.hpp"

/// Simulated sweeps over bones whose surface is known. Nothing here is clinical accuracy.
namespace nav::bench {

enum class BoneSite {
  kSpine,     ///< Lumbar vertebrae of sim::make_patient(), convex probe.
  kShoulder,  ///< Head of the humerus of sim::make_patient(), linear probe.
  kLongBone,  ///< Shaft and joint of a long bone, linear probe.
  kShaft,     ///< The shaft alone: nothing shows the position along it.
  kRibs,      ///< Three ribs over lung, with their front ends, linear probe.
  kNoBone,    ///< Soft tissue of a limb without a bone, linear probe.
};
inline constexpr int kBoneSites = 6;
const char* to_string(BoneSite site);

/// A sweep over bone with its CT and its truth.
struct BoneScene {
  Volume ct;
  std::shared_ptr<const sim::Anatomy> anatomy;
  Sweep sweep;                                              ///< With the errors of the level.
  CtPose truth;                                             ///< ct_from_reference.
  std::vector<Transform<frames::Ct, frames::Image>> views;  ///< True pose of each image.
  /// The CT is that of the other side of the body: mirrored in x about its middle.
  [[nodiscard]] Volume mirrored_ct() const;
};

/// level: errors of tracker and scanner; kIdeal to kPoor as for the cohort, without calibration,
/// delay and speed of sound. images: 2 or more.
Result<BoneScene> make_bone_scene(BoneSite site, std::uint64_t seed, ErrorLevel level, int images);

/// Depth of the first bone on a scan line, from the transducer, mm; absent: none down to the limit.
std::optional<double> true_bone_mm(const sim::Anatomy& anatomy,
                                   const Transform<frames::Ct, frames::Image>& view,
                                   const Eigen::Vector2d& start_mm, const Eigen::Vector2d& along,
                                   double limit_mm);

}  // namespace nav::bench
