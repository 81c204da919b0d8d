// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "registration/similarity/ct_channels.hpp"

/// Computes texels of the channels from voxels, for a whole box or for the part that is needed.
namespace nav::registration {

/// Positions of texels among voxels, and the width of the Gaussian.
struct TexelLattice {
  std::array<int, 3> first;                  ///< Voxel.
  std::array<int, 3> block;                  ///< Voxels averaged into a texel, >= 1.
  std::array<int, 3> size;                   ///< Texels, >= 1.
  std::array<std::vector<float>, 3> kernel;  ///< Half of each Gaussian: middle, its neighbour, ....
  Eigen::Vector3f gradient_scale;            ///< σ over texel spacing.
};

/// A block of texels from first on, clamped at the end of the lattice (an axis of one texel is
/// repeated).
struct TexelPart {
  std::array<int, 3> first, size;
};

/// Fills in the channels over the box without texels, and returns the lattice of the texels.
/// texel_sigmas: largest distance of texels in sigmas, subject to the limits of 1 mm and the voxels
/// in make_ct_channels(). Errors: those of make_ct_channels().
Result<TexelLattice> lattice_over(const Volume& ct, const CtBox& box, double sigma_mm,
                                  double texel_sigmas, CtChannels& channels);

/// Texels [from, to) of a row along i of a part; empty if to <= from.
struct TexelRun {
  int from, to;
};

/// The texels that are requested of a part, and their destination.
struct TexelOrder {
  TexelPart part;
  std::vector<TexelRun> runs;           ///< One for each row along i of the part, j fastest.
  std::span<std::array<float, 4>> out;  ///< Room for all texels of the part, i fastest.
};

/// Computes the texels of the orders' runs, which may overlap, in one pass over the CT, so that
/// none is smoothed twice; a texel does not depend on the part that it is in. Other texels stay
/// unchanged. The time grows with the runs together and the texels that the Gaussian reaches around
/// them. Precondition: sizes agree.
void fill_texels(const Volume& ct, const TexelLattice& lattice, std::span<const TexelOrder> orders);

/// Computes all texels of one part; out is resized to it.
void fill_texels(const Volume& ct, const TexelLattice& lattice, const TexelPart& part,
                 TexelArray& out);

}  // namespace nav::registration
