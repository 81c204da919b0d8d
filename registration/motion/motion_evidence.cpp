// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/motion/motion_evidence.hpp"

#include "registration/prepared.hpp"
#include "registration/similarity/ct_structure.hpp"
#include "registration/similarity/shadow_mask.hpp"
#include "registration/similarity/sweep_points.hpp"

namespace nav::registration {
namespace {

constexpr double kReachMm = 20;
// Same value as ImageRegistrationOptions::min_ct_contrast_hu.
constexpr double kMinCtContrastHu = 5;

}  // namespace

Result<std::vector<MotionEvidence>> motion_evidence(
    const Volume& ct, const Sweep& sweep, const Transform<frames::Ct, frames::Reference>& pose,
    const ShadowMaskOptions& mask, std::span<const LevelOptions> levels) {
  const auto masks = shadow_masks(sweep, mask);
  if (!masks) return masks.error();
  const auto points = sweep_points(sweep, *masks);
  const CtBox box = box_around(points, {pose}, kReachMm);
  std::vector<MotionEvidence> out;
  for (const LevelOptions& level : levels) {
    const double sigma_mm = sigma_of(level.sample_step_mm);
    auto channels = make_ct_channels(ct, box, sigma_mm);
    if (!channels) return channels.error();
    PatchSet patches = make_patches(sweep, *masks, level, sigma_mm);
    if (level.choice == PatchChoice::kEven) {
      patches = with_ct_structure(*channels, patches, pose, kMinCtContrastHu);
    }
    out.push_back({std::move(*channels), std::move(patches)});
  }
  return out;
}

Result<MotionEvidence> motion_evidence(const Volume& ct, const Sweep& sweep,
                                       const Transform<frames::Ct, frames::Reference>& pose,
                                       const ShadowMaskOptions& mask, const LevelOptions& level) {
  auto all = motion_evidence(ct, sweep, pose, mask, std::span(&level, 1));
  if (!all) return all.error();
  return std::move(all->front());
}

}  // namespace nav::registration
