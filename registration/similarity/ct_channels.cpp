// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/ct_channels.hpp"

#include <algorithm>

#include "registration/similarity/ct_texels.hpp"

namespace nav::registration {

CtBox box_of(const VoxelGrid& grid) {
  CtBox box{Eigen::Vector3d::Constant(1e300), Eigen::Vector3d::Constant(-1e300)};
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d index((corner & 1) != 0 ? grid.size[0] - 1 : 0,
                                (corner & 2) != 0 ? grid.size[1] - 1 : 0,
                                (corner & 4) != 0 ? grid.size[2] - 1 : 0);
    box.low = box.low.cwiseMin(grid.at(index).mm);
    box.high = box.high.cwiseMax(grid.at(index).mm);
  }
  return box;
}

Result<CtChannels> make_ct_channels(const Volume& ct, const CtBox& box, double sigma_mm,
                                    double texel_sigmas) {
  CtChannels out;
  const auto lattice = lattice_over(ct, box, sigma_mm, texel_sigmas, out);
  if (!lattice) return lattice.error();
  fill_texels(ct, *lattice, {{0, 0, 0}, out.size}, out.texels);
  return out;
}

}  // namespace nav::registration
