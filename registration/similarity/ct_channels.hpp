// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "nav/volume.hpp"

namespace nav::registration {

/// HU of one unit of f and g.
inline constexpr float kHuPerUnit = 100;

/// An allocator that leaves new elements uninitialised: texels are filled right after, where
/// needed.
template <class T>
struct UnsetAllocator : std::allocator<T> {
  UnsetAllocator() = default;
  template <class U>
  explicit UnsetAllocator(const UnsetAllocator<U>& /*other*/) noexcept {}
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    if constexpr (sizeof...(Args) == 0) {
      ::new (static_cast<void*>(at)) U;
    } else {
      ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
    }
  }
};
using TexelArray = std::vector<std::array<float, 4>, UnsetAllocator<std::array<float, 4>>>;

/// The CT channels of the similarity on one level: soft tissue and its gradient, smoothed, on the
/// CT's own axes. "Grid" coordinates are mm along the axes of the voxel grid from its first voxel:
/// y = directionsᵀ (p_ct − origin). Grid may be left-handed.
struct CtChannels {
  std::array<int, 3> size{};       ///< >= 2 along each axis; i fastest.
  Eigen::Vector3d spacing_mm;      ///< > 0.
  Eigen::Vector3d origin_ct_mm{};  ///< Centre of texel (0, 0, 0).
  Eigen::Matrix3d directions;      ///< ct_from_grid, orthonormal, det ±1.
  /// [f, gx, gy, gz]: f = clamp(HU, −150, 250)/100 smoothed; g = σ·∇f in Grid axes, so that both
  /// have the same unit and the same noise.
  TexelArray texels{};

  [[nodiscard]] Eigen::Vector3d grid_of(const Eigen::Vector3d& p_ct_mm) const {
    return directions.transpose() * (p_ct_mm - origin_ct_mm);
  }
};

/// A box in CT coordinates, mm.
struct CtBox {
  Eigen::Vector3d low, high;
};

/// The box of all voxel centres.
CtBox box_of(const VoxelGrid& grid);

/// Default distance of texels, in the Gaussian's sigmas.
inline constexpr double kTexelSigmas = 0.7;

/// Crops the CT to the box (whole voxels, at least 2 along each axis), smooths it with a Gaussian
/// of sigma_mm and keeps about one texel every texel_sigmas · sigma_mm, but none finer than 1 mm or
/// the CT. An axis with one voxel is repeated. Rejects a box that does not touch the CT (kRefused).
Result<CtChannels> make_ct_channels(const Volume& ct, const CtBox& box, double sigma_mm,
                                    double texel_sigmas = kTexelSigmas);

}  // namespace nav::registration
