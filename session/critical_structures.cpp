// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/critical_structures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

namespace nav::session {
namespace {

/// Distance of a point from a segment, mm.
double distance_to_path(const Eigen::Vector3d& point, const Eigen::Vector3d& from,
                        const Eigen::Vector3d& to) {
  const Eigen::Vector3d way = to - from;
  const double share = std::clamp((point - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
  return (point - from - share * way).norm();
}

/// Indices of the voxels of a box around the path, first and last along each axis.
std::pair<Eigen::Array3i, Eigen::Array3i> box_of(const VoxelGrid& grid, const NeedlePlan& plan) {
  Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array3d high = -low;
  for (const auto& point : {plan.entry_ct, plan.target_ct}) {
    const Eigen::Array3d index = grid.index_of(point).array();
    const Eigen::Array3d reach = kFarthestClearanceMm / grid.spacing_mm.array();
    low = low.min(index - reach);
    high = high.max(index + reach);
  }
  Eigen::Array3i first, last;
  for (int axis = 0; axis < 3; ++axis) {
    const double most = grid.size[static_cast<std::size_t>(axis)] - 1;
    first[axis] = static_cast<int>(std::clamp(std::floor(low[axis]), 0.0, most));
    last[axis] = static_cast<int>(std::clamp(std::ceil(high[axis]), 0.0, most));
  }
  return {first, last};
}

PathClearance nearest_voxel(const NeedlePlan& plan, const CriticalStructure::Values& values,
                            const Volume& ct) {
  const VoxelGrid& grid = ct.grid();
  const auto [first, last] = box_of(grid, plan);
  PathClearance found;
  double best = kFarthestClearanceMm;
  for (int k = first[2]; k <= last[2]; ++k) {
    for (int j = first[1]; j <= last[1]; ++j) {
      for (int i = first[0]; i <= last[0]; ++i) {
        const double hu = ct.at(i, j, k);
        if (!(hu >= values.low_hu && hu <= values.high_hu)) continue;
        const Point<frames::Ct> centre = grid.at(Eigen::Vector3d(i, j, k));
        const double distance = distance_to_path(centre.mm, plan.entry_ct.mm, plan.target_ct.mm);
        if (distance > best || (found.distance_mm && distance == best)) continue;
        best = distance;
        found.distance_mm = distance;
        found.nearest_ct = centre;
      }
    }
  }
  return found;
}

PathClearance to_sphere(const NeedlePlan& plan, const CriticalStructure::Sphere& sphere) {
  PathClearance found;
  found.distance_mm =
      distance_to_path(sphere.centre_ct.mm, plan.entry_ct.mm, plan.target_ct.mm) - sphere.radius_mm;
  found.nearest_ct = sphere.centre_ct;
  return found;
}

}  // namespace

Result<void> validate(const std::vector<CriticalStructure>& structures) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < structures.size(); ++i) {
    const CriticalStructure& one = structures[i];
    const std::string where = "critical_structures[" + std::to_string(i) + "]";
    const auto reject = [&](const char* key, const char* expected, auto found) {
      std::ostringstream text;
      text << where << key << ": expected " << expected << ", found " << found;
      return Error{ErrorCode::kUsage, text.str()};
    };
    if (one.name.empty()) return reject(".name", "a name", "none");
    if (!names.insert(one.name).second) return reject(".name", "a name of its own", one.name);
    if (one.sphere.has_value() == one.values.has_value()) {
      return reject("", "centre_mm with radius_mm, or low_hu with high_hu",
                    one.sphere ? "both" : "neither");
    }
    if (one.sphere && !(one.sphere->radius_mm >= 0.1 && one.sphere->radius_mm <= 500)) {
      return reject(".radius_mm", "0.1 to 500", one.sphere->radius_mm);
    }
    if (one.sphere && !(one.sphere->centre_ct.mm.norm() <= 1e6)) {
      return reject(".centre_mm", "a position within 10^6 mm", one.sphere->centre_ct.mm.norm());
    }
    if (one.values && !(one.values->low_hu < one.values->high_hu)) {
      return reject(".high_hu", "more than low_hu", one.values->high_hu);
    }
    if (!(one.clearance_mm >= 0 && one.clearance_mm <= 100)) {
      return reject(".clearance_mm", "0 to 100", one.clearance_mm);
    }
  }
  return {};
}

PathCheck check_path(const NeedlePlan& plan, const std::vector<CriticalStructure>& structures,
                     const Volume& ct) {
  const Eigen::Vector3d way = plan.target_ct.mm - plan.entry_ct.mm;
  PathCheck check;
  check.length_mm = way.norm();
  check.angle_to_axial_rad = std::asin(std::clamp(std::abs(way.z()) / check.length_mm, 0.0, 1.0));
  for (const CriticalStructure& one : structures) {
    PathClearance found =
        one.sphere ? to_sphere(plan, *one.sphere) : nearest_voxel(plan, *one.values, ct);
    found.name = one.name;
    found.too_near = found.distance_mm && *found.distance_mm < one.clearance_mm;
    check.clearances.push_back(std::move(found));
  }
  return check;
}

}  // namespace nav::session
