// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "nav/result.hpp"
#include "nav/transform.hpp"

namespace nav {

/// Positions of the voxel centres in coordinates of \p Frame (mm): p = origin_mm + directions ·
/// (spacing_mm ∘ (i, j, k)).
template <class Frame>
struct VoxelGridIn {
  std::array<int, 3> size{};                                 ///< Number of voxels along i, j, k.
  Eigen::Vector3d spacing_mm{1, 1, 1};                       ///< > 0.
  Eigen::Vector3d origin_mm{0, 0, 0};                        ///< Centre of voxel (0, 0, 0).
  Eigen::Matrix3d directions = Eigen::Matrix3d::Identity();  ///< Orthonormal columns; may be
                                                             ///< left-handed.

  [[nodiscard]] std::size_t voxel_count() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
           static_cast<std::size_t>(size[2]);
  }
  [[nodiscard]] Point<Frame> at(const Eigen::Vector3d& index) const {
    return {origin_mm + directions * spacing_mm.cwiseProduct(index)};
  }
  /// Continuous voxel index of a point.
  [[nodiscard]] Eigen::Vector3d index_of(const Point<Frame>& p) const {
    return (directions.transpose() * (p.mm - origin_mm)).cwiseQuotient(spacing_mm);
  }
  [[nodiscard]] Point<Frame> centre() const;
  /// Edge lengths of the box of voxel centres, extended by half a voxel at each side, mm.
  [[nodiscard]] Eigen::Vector3d extent_mm() const;
};

/// Grid in CT coordinates (LPS).
using VoxelGrid = VoxelGridIn<frames::Ct>;

/// Rejects sizes < 1 or more than 2^31 voxels in all, spacing outside [1e-4, 1e3] mm, directions
/// that are not orthonormal within 1e-4, and origins that are not finite. \p name: the volume's
/// name in the message.
template <class Frame>
Result<void> validate(const VoxelGridIn<Frame>& grid, const std::string& name);

/// Volume of any scalar type in any frame: ultrasound in stored values, features in float or in
/// fixed point, and, as the class Volume, CT in Hounsfield units. The values have no unit of their
/// own. A copy shares the voxels, which never change. Reading is thread-safe. Voxel order: i
/// fastest, then j, then k.
template <class Frame, class Scalar>
class VolumeOf {
 public:
  /// Rejects an invalid grid or a voxel count that does not match it. NaN is allowed in floating
  /// point. \p name: file name or phantom name, for messages.
  static Result<VolumeOf> create(const VoxelGridIn<Frame>& grid, std::vector<Scalar> values,
                                 std::string name);

  [[nodiscard]] const VoxelGridIn<Frame>& grid() const { return grid_; }
  /// Values of the voxels, i fastest. Valid while this volume or a copy lives.
  [[nodiscard]] std::span<const Scalar> values() const { return *values_; }
  /// Name of the volume in messages: file name or phantom name.
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Value of a voxel. Precondition: the index is inside the grid, otherwise a Bug.
  [[nodiscard]] Scalar at(int i, int j, int k) const;
  /// Trilinear value at a point; absent outside the box of voxel centres.
  [[nodiscard]] std::optional<double> sample(const Point<Frame>& p) const;

 private:
  VolumeOf(const VoxelGridIn<Frame>& grid, std::shared_ptr<const std::vector<Scalar>> values,
           std::string name)
      : grid_(grid), values_(std::move(values)), name_(std::move(name)) {}
  VoxelGridIn<Frame> grid_;
  std::shared_ptr<const std::vector<Scalar>> values_;
  std::string name_;
};

/// Volume of 16-bit stored values that lies in the CT frame: 3D ultrasound, the codes of features,
/// and every volume as the renderer sees it. 3D ultrasound has no frame of its own, because its
/// files give positions in patient axes (LPS), and no transform places it.
using StoredVolume = VolumeOf<frames::Ct, std::int16_t>;

/// HU of air; used outside a volume.
inline constexpr std::int16_t kAirHu = -1024;

/// CT volume in Hounsfield units. It is also a StoredVolume, so that the renderer draws it without
/// a copy. A StoredVolume becomes a CT only by explicit construction.
class Volume : public StoredVolume {
 public:
  /// Rejects an invalid grid or a voxel count that does not match it.
  static Result<Volume> create(const VoxelGrid& grid, std::vector<std::int16_t> hu,
                               std::string name);
  /// Declares that stored values are Hounsfield units. Shares the voxels.
  explicit Volume(StoredVolume in_hu) : StoredVolume(std::move(in_hu)) {}

  [[nodiscard]] std::span<const std::int16_t> hu() const { return values(); }
};

namespace detail {
/// Rejects a number of values other than the grid's.
Result<void> check_voxel_count(std::size_t expected, std::size_t found, const std::string& name);
/// Checks of validate() on the members of a grid.
Result<void> validate_grid(const std::array<int, 3>& size, const Eigen::Vector3d& spacing_mm,
                           const Eigen::Vector3d& origin_mm, const Eigen::Matrix3d& directions,
                           const std::string& name);
}  // namespace detail

template <class Frame>
Point<Frame> VoxelGridIn<Frame>::centre() const {
  return at(0.5 * Eigen::Vector3d(size[0] - 1, size[1] - 1, size[2] - 1));
}

template <class Frame>
Eigen::Vector3d VoxelGridIn<Frame>::extent_mm() const {
  return spacing_mm.cwiseProduct(Eigen::Vector3d(size[0], size[1], size[2]));
}

template <class Frame>
Result<void> validate(const VoxelGridIn<Frame>& grid, const std::string& name) {
  return detail::validate_grid(grid.size, grid.spacing_mm, grid.origin_mm, grid.directions, name);
}

template <class Frame, class Scalar>
Result<VolumeOf<Frame, Scalar>> VolumeOf<Frame, Scalar>::create(const VoxelGridIn<Frame>& grid,
                                                                std::vector<Scalar> values,
                                                                std::string name) {
  if (const auto ok = validate(grid, name); !ok) return ok.error();
  if (const auto ok = detail::check_voxel_count(grid.voxel_count(), values.size(), name); !ok) {
    return ok.error();
  }
  return VolumeOf(grid, std::make_shared<const std::vector<Scalar>>(std::move(values)),
                  std::move(name));
}

template <class Frame, class Scalar>
Scalar VolumeOf<Frame, Scalar>::at(int i, int j, int k) const {
  NAV_CHECK(
      i >= 0 && i < grid_.size[0] && j >= 0 && j < grid_.size[1] && k >= 0 && k < grid_.size[2], i,
      j, k);
  const auto row = static_cast<std::size_t>(grid_.size[0]);
  const auto slice = row * static_cast<std::size_t>(grid_.size[1]);
  return (*values_)[static_cast<std::size_t>(k) * slice + static_cast<std::size_t>(j) * row +
                    static_cast<std::size_t>(i)];
}

template <class Frame, class Scalar>
std::optional<double> VolumeOf<Frame, Scalar>::sample(const Point<Frame>& p) const {
  const Eigen::Vector3d index = grid_.index_of(p);
  std::array<int, 3> low{};
  std::array<int, 3> high{};
  Eigen::Vector3d w;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const int last = grid_.size[a] - 1;
    // Rounding must not move a point on the border outside.
    constexpr double kBorderTolerance = 1e-9;
    if (!(index[axis] >= -kBorderTolerance && index[axis] <= last + kBorderTolerance)) return {};
    const double clamped = std::clamp(index[axis], 0.0, static_cast<double>(last));
    low[a] = std::min(static_cast<int>(clamped), std::max(last - 1, 0));
    high[a] = std::min(low[a] + 1, last);
    w[axis] = clamped - low[a];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const bool x = (corner & 1) != 0;
    const bool y = (corner & 2) != 0;
    const bool z = (corner & 4) != 0;
    const double weight =
        (x ? w.x() : 1 - w.x()) * (y ? w.y() : 1 - w.y()) * (z ? w.z() : 1 - w.z());
    sum += weight * at(x ? high[0] : low[0], y ? high[1] : low[1], z ? high[2] : low[2]);
  }
  return sum;
}

// volume.cpp holds the code of the types that most files use.
extern template struct VoxelGridIn<frames::Ct>;
extern template Result<void> validate(const VoxelGridIn<frames::Ct>& grid, const std::string& name);
extern template class VolumeOf<frames::Ct, std::int16_t>;

}  // namespace nav
