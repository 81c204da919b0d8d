// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/volume.hpp"

#include <cmath>
#include <sstream>

namespace nav {

namespace detail {

Result<void> validate_grid(const std::array<int, 3>& size, const Eigen::Vector3d& spacing_mm,
                           const Eigen::Vector3d& origin_mm, const Eigen::Matrix3d& directions,
                           const std::string& name) {
  const auto reject = [&](const std::string& expected, const std::string& found) {
    return Error{ErrorCode::kMalformedData, name + ": expected " + expected + ", found " + found};
  };
  constexpr double kMaxVoxels = 2147483648.0;
  double voxels = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (size[a] < 1) {
      return reject("at least 1 voxel along axis " + std::to_string(axis), std::to_string(size[a]));
    }
    voxels *= size[a];
    const double spacing = spacing_mm[axis];
    // The limits are a tenth of a micrometre and a metre, beyond every scanner.
    if (!(spacing >= 1e-4 && spacing <= 1e3)) {
      std::ostringstream found;
      found << spacing;
      return reject("a spacing of 0.0001 to 1000 mm along axis " + std::to_string(axis),
                    found.str());
    }
  }
  std::ostringstream found;
  if (voxels > kMaxVoxels) {
    found << size[0] << " x " << size[1] << " x " << size[2];
    return reject("at most 2^31 voxels", found.str());
  }
  if (!origin_mm.allFinite()) {
    found << origin_mm.transpose();
    return reject("a finite origin in mm", found.str());
  }
  const Eigen::Matrix3d& d = directions;
  if (!d.allFinite() ||
      (d.transpose() * d - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-4) {
    found << "[" << d.row(0) << "; " << d.row(1) << "; " << d.row(2) << "]";
    return reject("orthonormal direction columns", found.str());
  }
  return {};
}

Result<void> check_voxel_count(std::size_t expected, std::size_t found, const std::string& name) {
  if (found == expected) return {};
  return Error{ErrorCode::kMalformedData, name + ": expected " + std::to_string(expected) +
                                              " voxels, found " + std::to_string(found)};
}

}  // namespace detail

template struct VoxelGridIn<frames::Ct>;
template Result<void> validate(const VoxelGridIn<frames::Ct>& grid, const std::string& name);
template class VolumeOf<frames::Ct, std::int16_t>;

Result<Volume> Volume::create(const VoxelGrid& grid, std::vector<std::int16_t> hu,
                              std::string name) {
  auto stored = StoredVolume::create(grid, std::move(hu), std::move(name));
  if (!stored) return stored.error();
  return Volume(*std::move(stored));
}

}  // namespace nav
