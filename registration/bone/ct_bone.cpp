// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/bone/ct_bone.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "nav/index.hpp"

namespace nav::registration {
namespace {

constexpr int kLowestSoftHu = -50;
constexpr int kHighestSoftHu = 150;
constexpr int kClearlyBoneHu = 250;  // Above soft tissue.
constexpr int kHighestHu = 2500;
constexpr double kLeastBoneShare = 2e-5;
constexpr double kLeastThresholdHu = 150;
constexpr double kMostThresholdHu = 700;

/// Indices of voxels and of their neighbours.
struct Lattice {
  std::array<int, 3> size;
  std::array<std::size_t, 3> stride;
  explicit Lattice(const VoxelGrid& grid)
      : size(grid.size),
        stride{1, as_size(grid.size[0]), as_size(grid.size[0]) * as_size(grid.size[1])} {}
  /// Calls visit(neighbour) for each of the six neighbours inside.
  template <class Visit>
  void around(std::size_t voxel, const Visit& visit) const {
    const std::array<int, 3> at = {static_cast<int>(voxel % stride[1]),
                                   static_cast<int>(voxel / stride[1] % as_size(size[1])),
                                   static_cast<int>(voxel / stride[2])};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (at[axis] > 0) visit(voxel - stride[axis]);
      if (at[axis] + 1 < size[axis]) visit(voxel + stride[axis]);
    }
  }
};

/// 1 for voxels outside bone that the largest connected part of the rest reaches without passing a
/// gap of one voxel.
std::vector<std::uint8_t> outside_bone(const std::vector<std::uint8_t>& bone,
                                       const Lattice& lattice) {
  std::vector<std::uint8_t> open(bone.size(), 0);
  for (std::size_t i = 0; i < bone.size(); ++i) {
    if (bone[i] != 0) continue;
    bool walled = false;
    lattice.around(i, [&](std::size_t j) { walled = walled || bone[j] != 0; });
    open[i] = walled ? 0 : 1;
  }
  std::vector<std::size_t> best, part;
  for (std::size_t seed = 0; seed < open.size(); ++seed) {
    if (open[seed] != 1) continue;
    part.assign(1, seed);
    open[seed] = 2;
    for (std::size_t k = 0; k < part.size(); ++k) {
      lattice.around(part[k], [&](std::size_t j) {
        if (open[j] != 1) return;
        open[j] = 2;
        part.push_back(j);
      });
    }
    if (part.size() > best.size()) best.swap(part);
  }
  std::vector<std::uint8_t> outside(bone.size(), 0);
  for (const std::size_t i : best) {
    outside[i] = 1;
    lattice.around(i, [&](std::size_t j) {
      if (bone[j] == 0) outside[j] = 1;
    });
  }
  return outside;
}

/// Gradient of the CT in index space by differences of neighbours.
Eigen::Vector3d index_gradient(const Volume& ct, const std::array<int, 3>& at) {
  Eigen::Vector3d out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<int, 3> low = at;
    std::array<int, 3> high = at;
    low[axis] = std::max(at[axis] - 1, 0);
    high[axis] = std::min(at[axis] + 1, ct.grid().size[axis] - 1);
    const int apart = std::max(high[axis] - low[axis], 1);
    out[static_cast<Eigen::Index>(axis)] =
        (ct.at(high[0], high[1], high[2]) - ct.at(low[0], low[1], low[2])) /
        static_cast<double>(apart);
  }
  return out;
}

}  // namespace

std::optional<double> bone_threshold_hu(const Volume& ct) {
  std::vector<std::size_t> counts(as_size(kHighestHu) + 1001, 0);
  for (const std::int16_t hu : ct.hu()) {
    ++counts[as_size(std::clamp<int>(hu, -1000, kHighestHu) + 1000)];
  }
  const auto count = [&](int hu) { return counts[as_size(hu + 1000)]; };
  int soft = kLowestSoftHu;
  std::size_t most = 0;
  constexpr int kBinHu = 10;
  for (int low = kLowestSoftHu; low < kHighestSoftHu; low += kBinHu) {
    std::size_t sum = 0;
    for (int hu = low; hu < low + kBinHu; ++hu) sum += count(hu);
    if (sum <= most) continue;
    most = sum;
    soft = low + kBinHu / 2;
  }
  std::size_t bright = 0;
  for (int hu = soft + kClearlyBoneHu; hu <= kHighestHu; ++hu) bright += count(hu);
  if (static_cast<double>(bright) < kLeastBoneShare * static_cast<double>(ct.hu().size()))
    return {};
  std::size_t seen = 0;
  int middle = soft + kClearlyBoneHu;
  while (middle < kHighestHu && 2 * (seen += count(middle)) < bright) ++middle;
  return std::clamp(0.5 * (soft + middle), kLeastThresholdHu, kMostThresholdHu);
}

Result<Shape> bone_surface(const Volume& ct, double threshold_hu,
                           const std::pair<Eigen::Vector3d, Eigen::Vector3d>& within_ct_mm) {
  const VoxelGrid& grid = ct.grid();
  const Lattice lattice(grid);
  const auto hu = ct.hu();
  std::vector<std::uint8_t> bone(hu.size());
  for (std::size_t i = 0; i < hu.size(); ++i) bone[i] = hu[i] >= threshold_hu ? 1 : 0;
  const std::vector<std::uint8_t> outside = outside_bone(bone, lattice);
  Shape shape{ShapeKind::kSurface, {}, std::max(grid.spacing_mm.maxCoeff(), 0.5), ct.name()};
  const Eigen::AlignedBox3d box(within_ct_mm.first, within_ct_mm.second);
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const std::array<int, 3> at = {i, j, k};
        const std::size_t voxel =
            as_size(k) * lattice.stride[2] + as_size(j) * lattice.stride[1] + as_size(i);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (at[axis] + 1 >= grid.size[axis]) continue;
          const std::size_t next = voxel + lattice.stride[axis];
          const bool leaves = bone[voxel] != 0 && outside[next] != 0;
          const bool enters = bone[next] != 0 && outside[voxel] != 0;
          if (!leaves && !enters) continue;
          const double share = (threshold_hu - hu[voxel]) / (hu[next] - hu[voxel]);
          Eigen::Vector3d index(i, j, k);
          index[static_cast<Eigen::Index>(axis)] += share;
          const Eigen::Vector3d p = grid.at(index).mm;
          if (!box.contains(p)) continue;
          std::array<int, 3> other = at;
          ++other[axis];
          const Eigen::Vector3d slope =
              ((1 - share) * index_gradient(ct, at) + share * index_gradient(ct, other))
                  .cwiseQuotient(grid.spacing_mm);
          const Eigen::Vector3d normal = -(grid.directions * slope);
          if (normal.norm() > 0) shape.elements.push_back({p, normal.normalized()});
        }
      }
    }
  }
  if (shape.elements.empty()) {
    std::ostringstream text;
    text << ct.name() << ": expected bone (above " << std::lround(threshold_hu)
         << " HU) around the sweep, found none";
    return Error{ErrorCode::kMalformedData, text.str()};
  }
  return shape;
}

Result<Shape> outward_shape(const TriangleMesh& mesh, double spacing_mm) {
  auto shape = surface_shape(mesh, spacing_mm);
  if (!shape) return shape;
  const Eigen::Vector3d middle = shape->elements.front().point_mm;
  double six_volumes = 0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const auto corner = [&, c = middle](int n) {
      return Eigen::Vector3d(mesh.points_mm[as_size(n)] - c);
    };
    six_volumes += corner(i).dot(corner(j).cross(corner(k)));
  }
  if (six_volumes < 0) {
    for (ShapeElement& one : shape->elements) one.axis = -one.axis;
  }
  return shape;
}

}  // namespace nav::registration
