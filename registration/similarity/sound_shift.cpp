// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/sound_shift.hpp"

#include <algorithm>
#include <cmath>

namespace nav::registration {
namespace {

constexpr double kAssumedSpeed = 1540;
constexpr double kPieceMm = 2;
constexpr double kFatHu = -100, kOrganHu = 55;
// Beyond these, air, gas and bone.
constexpr double kDarkestTissueHu = -140, kBrightestTissueHu = 240;

/// HU at the texel that is nearest to a point; the limit of air outside the channels.
double hu_at(const CtChannels& ct, const Eigen::Vector3d& p_ct_mm) {
  const Eigen::Array3d at = ct.grid_of(p_ct_mm).array() / ct.spacing_mm.array();
  std::array<std::size_t, 3> index{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double rounded = std::floor(at[static_cast<Eigen::Index>(axis)] + 0.5);
    if (!(rounded >= 0 && rounded < ct.size[axis])) return 10 * kDarkestTissueHu;
    index[axis] = static_cast<std::size_t>(rounded);
  }
  const auto nx = static_cast<std::size_t>(ct.size[0]);
  const auto ny = static_cast<std::size_t>(ct.size[1]);
  const std::size_t texel = (index[2] * ny + index[1]) * nx + index[0];
  return static_cast<double>(kHuPerUnit * ct.texels[texel][0]);
}

/// Shown minus true depth of an echo that is shown at a depth. The beam starts at \p face.
double shift_mm(const CtChannels& ct, const Eigen::Vector3d& face, const Eigen::Vector3d& beam,
                double shown_mm) {
  double shown = 0;
  double depth = 0;
  while (shown < shown_mm) {
    const double hu = hu_at(ct, face + (depth + 0.5 * kPieceMm) * beam);
    const bool tissue = hu > kDarkestTissueHu && hu < kBrightestTissueHu;
    const double slowness = tissue ? kAssumedSpeed / sound_speed_at(hu) : 1;
    const double piece = std::min(kPieceMm, (shown_mm - shown) / slowness);
    depth += piece;
    shown += piece * slowness;
    if (piece < kPieceMm) break;
  }
  return shown_mm - depth;
}

}  // namespace

double sound_speed_at(double hu) {
  const double density = 1.018 + 0.893e-3 * std::clamp(hu, kFatHu, kOrganHu);  // g / cm³
  return 1e3 * (1.12 * density + 0.391);
}

std::vector<float> sound_shifts_mm(const CtChannels& ct, const PatchSet& patches,
                                   const Transform<frames::Ct, frames::Reference>& pose) {
  std::vector<float> shifts;
  for (const Patch& patch : patches.patches) {
    if (patch.index >= shifts.size()) shifts.resize(patch.index + 1, 0.0F);
    const Point<frames::Reference> face{patch.centre_mm - patch.depth_mm * patch.beam};
    shifts[patch.index] = static_cast<float>(shift_mm(
        ct, (pose * face).mm, (pose * Direction<frames::Reference>{patch.beam}).v, patch.depth_mm));
  }
  return shifts;
}

}  // namespace nav::registration
