// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nav/volume.hpp"
#include "render/features/run.hpp"
#include "render/features/volume.hpp"

namespace nav::render::features {

/// Up to 32 labels per voxel, one bit each: the second form of the paper's label predicate
/// (Schulte zu Berge et al. 2014, §3.1). Copying copies a pointer; thread-safe to read.
class LabelVolume {
 public:
  /// Refuses a bad grid and another number of masks.
  static Result<LabelVolume> create(const VoxelGrid& grid, std::vector<std::uint32_t> masks,
                                    const std::string& name);

  [[nodiscard]] const VoxelGrid& grid() const { return grid_; }
  [[nodiscard]] const std::vector<std::uint32_t>& masks() const { return *masks_; }
  [[nodiscard]] std::uint32_t at(int i, int j, int k) const {
    return (*masks_)[offset_of(grid_, i, j, k)];
  }
  /// Mask of the nearest voxel; 0 outside the box of voxel centres plus half a voxel.
  [[nodiscard]] std::uint32_t nearest(const Eigen::Vector3d& voxel) const;

 private:
  LabelVolume() = default;
  VoxelGrid grid_;
  std::shared_ptr<const std::vector<std::uint32_t>> masks_;
};

/// A boundary between two layers of tissue as a height over two axes of a voxel grid: a uniform
/// cubic B-spline (de Boor 1978), the first form of the paper's label predicate.
class LayerSurface {
 public:
  /// Heights of control points, voxels along `axis`, first u then v, the two other axes in order.
  /// The control points span the grid's size along u and v, one more on each side. Refuses axes
  /// other than 0, 1, 2, fewer than 4 control points along either side, another number of heights
  /// and heights that are not finite.
  static Result<LayerSurface> create(int axis, const std::array<int, 3>& grid_size,
                                     const std::array<int, 2>& control,
                                     std::vector<double> heights);

  [[nodiscard]] int axis() const { return axis_; }
  [[nodiscard]] const std::array<int, 3>& grid_size() const { return size_; }
  /// Exact height at continuous voxel indices (u, v), voxels; beyond the grid the border's counts.
  [[nodiscard]] double height(double u, double v) const;
  /// Least upper bound of |dh/du| and |dh/dv| that the control points give.
  [[nodiscard]] Eigen::Vector2d steepest() const;

 private:
  LayerSurface() = default;
  int axis_ = 2;
  std::array<int, 3> size_{};
  std::array<int, 2> control_{};
  std::vector<double> heights_;
};

/// Layers between surfaces: layer 0 lies below all of them, layer n above all. Where surfaces
/// cross, the layer is the number of surfaces below.
class LayerModel {
 public:
  /// Refuses no surfaces, more than 31, and different axes or grids.
  static Result<LayerModel> create(std::vector<LayerSurface> surfaces);

  /// Layer at a continuous voxel index, exactly.
  [[nodiscard]] int layer_at(const Eigen::Vector3d& voxel) const;
  /// Bit n of every mask: the voxel's centre lies in layer n.
  [[nodiscard]] Result<LabelVolume> rasterise(const VoxelGrid& grid,
                                              const RunOptions& run = {}) const;
  /// No point further than this from every surface, measured along the axis, gets another label
  /// from the raster's nearest voxel than from layer_at(): (1 + |dh/du| + |dh/dv|) / 2, voxels.
  [[nodiscard]] double raster_error_voxels() const;

 private:
  LayerModel() = default;
  std::vector<LayerSurface> surfaces_;
};

}  // namespace nav::render::features
