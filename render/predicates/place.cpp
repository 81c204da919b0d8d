// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/place.hpp"

#include <sstream>

#include "nav/positions.hpp"

namespace nav::render {
namespace {

std::string text_of(const Eigen::Vector3d& v) {
  std::ostringstream text;
  text << v.x() << " " << v.y() << " " << v.z();
  return text.str();
}

Result<void> check(const ParallelScan& scan, const VoxelGrid&) {
  if (!is_place(scan.face_ct.mm)) {
    return malformed_predicates("scan.face_ct: expected numbers within 1e7 mm, found " +
                                text_of(scan.face_ct.mm));
  }
  if (!scan.into_ct.v.allFinite() || scan.into_ct.v.isZero(0)) {
    return malformed_predicates("scan.into_ct: expected a direction, found a zero vector or NaN");
  }
  return {};
}

Result<void> check(const FanScan& scan, const VoxelGrid&) {
  if (!is_place(scan.apex_ct.mm)) {
    return malformed_predicates("scan.apex_ct: expected numbers within 1e7 mm, found " +
                                text_of(scan.apex_ct.mm));
  }
  if (!(scan.face_radius_mm >= 0 && scan.face_radius_mm <= kFurthestMm)) {
    std::ostringstream found;
    found << scan.face_radius_mm;
    return malformed_predicates("scan.face_radius_mm: expected a radius of 0 to 1e7 mm, found " +
                                found.str());
  }
  return {};
}

Result<void> check(const VoxelScan& scan, const VoxelGrid& grid) {
  const std::size_t found = scan.into_ct ? scan.into_ct->size() : 0;
  if (found == grid.voxel_count()) return {};
  return malformed_predicates("scan.into_ct: expected a direction for each of " +
                              std::to_string(grid.voxel_count()) + " voxels, found " +
                              std::to_string(found));
}

}  // namespace

Result<void> validate(const ScanGeometry& scan, const VoxelGrid& grid) {
  return std::visit([&](const auto& s) { return check(s, grid); }, scan);
}

bool same_scan(const std::optional<ScanGeometry>& a, const std::optional<ScanGeometry>& b) {
  if (!a || !b || a->index() != b->index()) return !a && !b;
  if (const auto* parallel = std::get_if<ParallelScan>(&*a)) {
    const auto& other = std::get<ParallelScan>(*b);
    return parallel->face_ct.mm == other.face_ct.mm && parallel->into_ct.v == other.into_ct.v;
  }
  if (const auto* fan = std::get_if<FanScan>(&*a)) {
    const auto& other = std::get<FanScan>(*b);
    return fan->apex_ct.mm == other.apex_ct.mm && fan->face_radius_mm == other.face_radius_mm;
  }
  return std::get<VoxelScan>(*a).into_ct == std::get<VoxelScan>(*b).into_ct;
}

bool same_surroundings(const PredicatePosition& a, const PredicatePosition& b) {
  const auto same = [](const std::optional<Segment>& x, const std::optional<Segment>& y) {
    if (!x || !y) return !x && !y;
    return x->a == y->a && x->b == y->b && x->radius_mm == y->radius_mm;
  };
  return same_scan(a.scan, b.scan) && same(a.needle, b.needle) && same(a.target, b.target);
}

}  // namespace nav::render
