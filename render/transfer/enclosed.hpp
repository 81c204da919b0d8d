// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "nav/volume.hpp"

namespace nav::render {

/// Neighbours of the voxels of a grid, by their number in the order of a volume.
class VoxelLattice {
 public:
  explicit VoxelLattice(const VoxelGrid& grid)
      : size_{static_cast<std::size_t>(grid.size[0]), static_cast<std::size_t>(grid.size[1]),
              static_cast<std::size_t>(grid.size[2])},
        spacing_mm_(grid.spacing_mm) {}

  [[nodiscard]] std::size_t size(int axis) const { return size_[static_cast<std::size_t>(axis)]; }
  [[nodiscard]] std::size_t count() const { return size_[0] * size_[1] * size_[2]; }
  [[nodiscard]] std::size_t stride(int axis) const {
    return axis == 0 ? 1 : axis == 1 ? size_[0] : size_[0] * size_[1];
  }
  [[nodiscard]] double spacing_mm(int axis) const { return spacing_mm_[axis]; }
  /// Calls work(n) for each of the up to six neighbours of voxel i.
  template <class Work>
  void for_each_neighbour(std::size_t i, const Work& work) const {
    const std::size_t x = i % size_[0];
    const std::size_t y = i / size_[0] % size_[1];
    const std::size_t z = i / (size_[0] * size_[1]);
    if (x > 0) work(i - 1);
    if (x + 1 < size_[0]) work(i + 1);
    if (y > 0) work(i - size_[0]);
    if (y + 1 < size_[1]) work(i + size_[0]);
    if (z > 0) work(i - size_[0] * size_[1]);
    if (z + 1 < size_[2]) work(i + size_[0] * size_[1]);
  }

 private:
  std::array<std::size_t, 3> size_;
  Eigen::Vector3d spacing_mm_;
};

/// Voxels (1) from which no neighbour differs by more than 60 HU: inside a vessel or an organ, not
/// at its rim.
std::vector<std::uint8_t> homogeneous_voxels(const VoxelLattice& lattice,
                                             std::span<const std::int16_t> hu);

/// Voxels (1) that a closed contour of a mask encloses in a slice of one of the three orientations.
/// Gaps of up to two voxels are closed. Regions of more than 25 cm² are not enclosed: a pelvis or a
/// chest has no marrow. Voxels of the mask itself are 0.
std::vector<std::uint8_t> enclosed_voxels(const VoxelLattice& lattice,
                                          std::span<const std::uint8_t> mask);

/// A mask, of 0 and 1, and everything within some voxels of it, by faces.
std::vector<std::uint8_t> within_voxels(const VoxelLattice& lattice, std::vector<std::uint8_t> mask,
                                        int voxels);

/// Components of a mask, connected by faces, each with the numbers of its voxels.
std::vector<std::vector<std::uint32_t>> components_of(const VoxelLattice& lattice,
                                                      std::span<const std::uint8_t> mask);

}  // namespace nav::render
