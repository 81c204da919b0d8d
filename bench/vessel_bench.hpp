// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/volume.hpp"
#include "render/transfer/transfer_function.hpp"
#include "render/transfer/vessel_fit.hpp"

namespace nav::bench {

/// Truth about the voxels of a CT.
struct VesselTruth {
  std::vector<std::uint8_t> blood;  ///< 1: labelled blood.
  std::vector<std::uint8_t> bone;   ///< 1: bone, by the definition that the report states.
};

/// How well the component "vessels" of an appearance shows blood and nothing else. A voxel is
/// visible as vessel where the component has at least half of its greatest opacity.
struct VesselFigures {
  double blood_visible = 0;  ///< Share of labelled blood that is visible as vessel.
  double bone_share = 0;     ///< Share of the voxels visible as vessel that lie in bone.
  double visible_ml = 0;
};

/// Figures of a transfer function with absolute values, as it is.
VesselFigures figures_as_it_is(const Volume& ct, const render::TransferFunction& transfer,
                               const VesselTruth& truth);
/// Figures after the fit to the CT's blood, and the pool and window that were found.
struct FittedVessels {
  VesselFigures figures;
  std::optional<render::BloodPool> pool;
  render::VesselWindow window{};
  double classify_s = 0;  ///< Time of finding, classifying and separating.
};
Result<FittedVessels> figures_fitted(const Volume& ct, const render::TransferFunction& transfer,
                                     const VesselTruth& truth);

/// Bone of a CT without labels of all bones: given labels, and every voxel within two voxels (by
/// faces) of one above 700 HU, unless that lies within three voxels of a labelled artery (a stent);
/// but no labelled artery.
std::vector<std::uint8_t> bone_by_density(const Volume& ct, const std::vector<std::uint8_t>& artery,
                                          const std::vector<std::uint8_t>& labelled_bone);

}  // namespace nav::bench
