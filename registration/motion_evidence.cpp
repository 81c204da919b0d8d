// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/motion_evidence.hpp"

#include "registration/shadow_mask.hpp"
#include "registration/sweep_points.hpp"

namespace nav::registration {
namespace {

constexpr double kSigmaPerStep = 0.75;
constexpr double kReachMm = 20;

}  // namespace

Result<MotionEvidence> motion_evidence(const Volume& ct, const Sweep& sweep,
                                       const Transform<frames::Ct, frames::Reference>& pose,
                                       const ShadowMaskOptions& mask, const LevelOptions& level) {
  const auto masks = shadow_masks(sweep, mask);
  if (!masks) return masks.error();
  const auto points = sweep_points(sweep, *masks);
  const double sigma_mm = kSigmaPerStep * level.sample_step_mm;
  auto channels = make_ct_channels(ct, box_around(points, {pose}, kReachMm), sigma_mm);
  if (!channels) return channels.error();
  return MotionEvidence{std::move(*channels), make_patches(sweep, *masks, level, sigma_mm)};
}

}  // namespace nav::registration
