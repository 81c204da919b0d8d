// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/motion/volume_sweep.hpp"

#include <array>

namespace nav::registration {
namespace {

Error malformed(const UltrasoundVolume& volume, const std::string& expected,
                const std::string& found) {
  return {ErrorCode::kMalformedData, volume.name + ": expected " + expected + ", found " + found};
}

Result<void> check(const UltrasoundVolume& volume) {
  if (auto ok = validate(volume.grid, volume.name); !ok) return ok;
  if (volume.grey.size() != volume.grid.voxel_count()) {
    return malformed(volume, std::to_string(volume.grid.voxel_count()) + " voxels",
                     std::to_string(volume.grey.size()));
  }
  const int a = volume.lateral_axis;
  const int b = volume.depth_axis;
  if (a < 0 || a > 2 || b < 0 || b > 2 || a == b) {
    return malformed(volume, "two different axes of 0, 1, 2",
                     std::to_string(a) + " and " + std::to_string(b));
  }
  const int slices = volume.grid.size[static_cast<std::size_t>(3 - a - b)];
  if (slices < 2) return malformed(volume, "at least 2 slices", std::to_string(slices));
  return {};
}

/// Pixels of slice k; rows run along the depth axis.
Image2d<std::uint8_t> slice_of(const UltrasoundVolume& volume, std::size_t across, int k) {
  const auto lateral = static_cast<std::size_t>(volume.lateral_axis);
  const auto depth = static_cast<std::size_t>(volume.depth_axis);
  const auto& size = volume.grid.size;
  const std::array<std::size_t, 3> stride{
      1, static_cast<std::size_t>(size[0]),
      static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1])};
  std::vector<std::uint8_t> pixels;
  pixels.reserve(static_cast<std::size_t>(size[lateral]) * static_cast<std::size_t>(size[depth]));
  for (std::size_t row = 0; row < static_cast<std::size_t>(size[depth]); ++row) {
    for (std::size_t column = 0; column < static_cast<std::size_t>(size[lateral]); ++column) {
      pixels.push_back(volume.grey[static_cast<std::size_t>(k) * stride[across] +
                                   row * stride[depth] + column * stride[lateral]]);
    }
  }
  return {size[lateral], size[depth], std::move(pixels)};
}

}  // namespace

Result<Sweep> sweep_of_volume(const UltrasoundVolume& volume) {
  if (const auto ok = check(volume); !ok) return ok.error();
  const int lateral = volume.lateral_axis;
  const int depth = volume.depth_axis;
  const auto across = static_cast<std::size_t>(3 - lateral - depth);
  const VoxelGrid& grid = volume.grid;
  Eigen::Matrix3d axes;
  axes.col(0) = grid.directions.col(lateral);
  axes.col(1) = grid.directions.col(depth);
  axes.col(2) = axes.col(0).cross(axes.col(1));
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(axes).normalized();
  std::vector<TrackedImage> frames;
  for (int k = 0; k < grid.size[across]; ++k) {
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    first[static_cast<Eigen::Index>(across)] = k;
    first[lateral] = 0.5 * (grid.size[static_cast<std::size_t>(lateral)] - 1);
    UltrasoundImage frame;
    // Only the order of the slices; a volume has a single time.
    frame.acquired = Timestamp(from_seconds(1e-3 * k));
    frame.received = frame.acquired;
    frame.sequence = static_cast<std::uint64_t>(k);
    frame.pixels = slice_of(volume, across, k);
    frame.grid =
        PixelGrid::centred(frame.pixels.width(), grid.spacing_mm[lateral], grid.spacing_mm[depth]);
    frame.outline = volume.outline;
    frames.push_back({std::move(frame),
                      Transform<frames::Reference, frames::Image>(rotation, grid.at(first).mm),
                      Duration{0}});
  }
  return Sweep::create(std::move(frames), volume.name);
}

}  // namespace nav::registration
