// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/ct_structure.hpp"

#include <array>
#include <cmath>
#include <limits>

namespace nav::registration {
namespace {

constexpr int kSide = 5;
constexpr std::size_t kPoints = kSide * kSide;
constexpr std::size_t kLeastPatches = 100;

}  // namespace

double ct_contrast_hu(const CtChannels& ct, const PatchSet& patches, std::size_t patch,
                      const GridPose& pose, PatchChannels* near) {
  PlacedPatch placed = place(patches, patch, pose);
  const double stride = static_cast<double>(placed.side - 1) / (kSide - 1);
  placed.step_a *= stride;
  placed.step_b *= stride;
  placed.side = kSide;
  std::array<float, kPoints> f{};
  const CtChannels& here =
      near != nullptr ? near->around(patches.patches[patch].index, placed) : ct;
  if (!patch_intensities(here, placed, f, {})) return std::numeric_limits<double>::infinity();
  double sum = 0;
  double squares = 0;
  for (const float value : f) {
    sum += value;
    squares += static_cast<double>(value) * value;
  }
  const double mean = sum / kPoints;
  return kHuPerUnit * std::sqrt(std::max(squares / kPoints - mean * mean, 0.0));
}

PatchSet with_ct_structure(const CtChannels& ct, const PatchSet& patches, const Pose& pose,
                           double min_contrast_hu, PatchChannels* near) {
  const GridPose at = grid_pose(ct, pose);
  std::size_t index = 0;
  PatchSet kept = subset(patches, [&](const Patch&) {
    return ct_contrast_hu(ct, patches, index++, at, near) >= min_contrast_hu;
  });
  if (kept.patches.size() >= kLeastPatches) return kept;
  return patches;
}

}  // namespace nav::registration
