// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "registration/similarity/ct_channels.hpp"

/// How texels of the channels are made of voxels: for a whole box or for the part that is looked
/// at.
namespace nav::registration {

/// Where texels lie among voxels, and how wide the Gaussian is there.
struct TexelLattice {
  std::array<int, 3> first;                  ///< Voxel.
  std::array<int, 3> block;                  ///< Voxels averaged into a texel, >= 1.
  std::array<int, 3> size;                   ///< Texels, >= 1.
  std::array<std::vector<float>, 3> kernel;  ///< Half of each Gaussian: middle, its neighbour, ....
  Eigen::Vector3f gradient_scale;            ///< σ over texel spacing.
};

/// Texels from first on, clamped where the lattice ends (an axis of one texel is repeated).
struct TexelPart {
  std::array<int, 3> first, size;
};

/// Channels over the box without texels, and the lattice that these are on. texel_sigmas: how far
/// texels are apart at most, in sigmas, but for the 1 mm and the voxels of make_ct_channels().
/// Errors: those of make_ct_channels().
Result<TexelLattice> lattice_over(const Volume& ct, const CtBox& box, double sigma_mm,
                                  double texel_sigmas, CtChannels& channels);

/// Texels of a row along i, [from, to) of the part's; empty where to <= from.
struct TexelRun {
  int from, to;
};

/// What is wanted of a part, and where it goes.
struct TexelOrder {
  TexelPart part;
  std::vector<TexelRun> runs;           ///< Of each row along i of the part, j fastest.
  std::span<std::array<float, 4>> out;  ///< Of all of the part, i fastest.
};

/// Makes the texels of the orders' runs, which may overlap, in one pass over the CT, so that none
/// is smoothed twice: each is the same whichever part it is in. Others stay as they are. Time: that
/// of the runs together and what the Gaussian reaches about them. Precondition: sizes that agree.
void fill_texels(const Volume& ct, const TexelLattice& lattice, std::span<const TexelOrder> orders);

/// The same for all texels of one part; out is made of its size.
void fill_texels(const Volume& ct, const TexelLattice& lattice, const TexelPart& part,
                 TexelArray& out);

}  // namespace nav::registration
