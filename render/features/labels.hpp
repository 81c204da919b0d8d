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

/// Up to 32 labels per voxel, one bit each: the second form of the paper's label predicate (Schulte
/// zu Berge et al. 2014, §3.1). Copying copies a pointer; thread-safe to read.
class LabelVolume {
 public:
  /// Rejects an invalid grid and a number of masks that does not match it.
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
  /// Creates a surface from the heights of its control points. Heights are in voxels along `axis`;
  /// u varies fastest, then v; u and v are the two other axes in order. The control points span the
  /// grid's size along u and v, plus one point on each side. Rejects axes other than 0, 1, 2, fewer
  /// than 4 control points along a side, a wrong number of heights, and heights that are not
  /// finite.
  static Result<LayerSurface> create(int axis, const std::array<int, 3>& grid_size,
                                     const std::array<int, 2>& control,
                                     std::vector<double> heights);

  [[nodiscard]] int axis() const { return axis_; }
  [[nodiscard]] const std::array<int, 3>& grid_size() const { return size_; }
  /// Exact height at continuous voxel indices (u, v), voxels. Outside the grid, the height at its
  /// border.
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

/// Layers between surfaces. Layer 0 lies below all surfaces, layer n above all. If surfaces cross,
/// the layer is the number of surfaces below.
class LayerModel {
 public:
  /// Rejects an empty list, more than 31 surfaces, and different axes or grids.
  static Result<LayerModel> create(std::vector<LayerSurface> surfaces);

  /// Exact layer at a continuous voxel index.
  [[nodiscard]] int layer_at(const Eigen::Vector3d& voxel) const;
  /// Rasterises the layers: bit n of a mask is set if the voxel's centre lies in layer n.
  [[nodiscard]] Result<LabelVolume> rasterise(const VoxelGrid& grid,
                                              const RunOptions& run = {}) const;
  /// Greatest distance from a surface, along the axis, at which the label of the raster's nearest
  /// voxel can differ from layer_at(): (1 + |dh/du| + |dh/dv|) / 2, voxels.
  [[nodiscard]] double raster_error_voxels() const;

 private:
  LayerModel() = default;
  std::vector<LayerSurface> surfaces_;
};

}  // namespace nav::render::features
