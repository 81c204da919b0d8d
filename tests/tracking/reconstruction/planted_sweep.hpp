// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "tracking/reconstruction/reconstruction.hpp"
#include "tracking/reconstruction/sweep_grid.hpp"

namespace nav::test {

using ReferenceFromImage = Transform<frames::Reference, frames::Image>;
using Field = std::function<double(const Eigen::Vector3d& mm)>;

/// Image of \p columns x \p rows pixels whose values are those of a field in the Reference frame.
inline TrackedImage image_of(const Field& field, const ReferenceFromImage& pose, int columns,
                             int rows, double pixel_mm) {
  UltrasoundImage frame;
  frame.grid = {Eigen::Vector2d::Constant(pixel_mm).asDiagonal(), {0, 0}};
  std::vector<std::uint8_t> pixels;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      pixels.push_back(
          static_cast<std::uint8_t>(std::lround(field((pose * frame.grid.at(column, row)).mm))));
    }
  }
  frame.pixels = Image2d<std::uint8_t>(columns, rows, std::move(pixels));
  return {frame, pose, Duration(0)};
}

/// An oblique orientation, which is parallel to no axis.
inline Eigen::Quaterniond oblique() {
  return Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, -0.5).normalized()) *
                            Eigen::AngleAxisd(-0.3, Eigen::Vector3d::UnitY()));
}

/// Images of 64 x 56 pixels of 0.25 mm, 0.4 mm apart along their normal, which also turn a little.
inline std::vector<TrackedImage> sweep_of(const Field& field, int images) {
  std::vector<TrackedImage> sweep;
  for (int n = 0; n < images; ++n) {
    const Eigen::Quaterniond turn =
        oblique() * Eigen::AngleAxisd(0.004 * n, Eigen::Vector3d::UnitX());
    const Eigen::Vector3d at =
        Eigen::Vector3d(3, -8, 11) + oblique() * Eigen::Vector3d(0, 0, 0.4 * n);
    sweep.push_back(image_of(field, ReferenceFromImage(turn, at), 64, 56, 0.25));
    sweep.back().frame.sequence = static_cast<std::uint64_t>(n);
  }
  return sweep;
}

inline std::shared_ptr<const tracking::ImageArea> whole_area(const TrackedImage& image) {
  return std::make_shared<tracking::ImageArea>(image.frame, tracking::PlusClip{});
}

inline VoxelGridIn<frames::Reference> grid_around(const std::vector<TrackedImage>& sweep,
                                                  double spacing_mm, int margin = 2) {
  std::vector<Point<frames::Reference>> corners;
  for (const TrackedImage& image : sweep) {
    for (const Eigen::Vector2d& corner : whole_area(image)->corners()) {
      corners.push_back(image.reference_from_image * image.frame.grid.at(corner.x(), corner.y()));
    }
  }
  return *tracking::sweep_grid(tracking::sweep_extent(corners), spacing_mm, margin);
}

inline tracking::Reconstruction reconstruct(const std::vector<TrackedImage>& sweep,
                                            const VoxelGridIn<frames::Reference>& grid,
                                            const tracking::ReconstructionOptions& options) {
  auto volume = *tracking::Reconstruction::create(grid, options);
  for (const TrackedImage& image : sweep) volume.add(image, whole_area(image));
  return volume;
}

/// Calls visit(index, offset) for every voxel.
template <class Visit>
void for_each_voxel(const std::array<int, 3>& size, const Visit& visit) {
  std::size_t offset = 0;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) visit(Eigen::Vector3d(i, j, k), offset++);
    }
  }
}

}  // namespace nav::test
