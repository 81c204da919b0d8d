// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/place.hpp"

#include <cmath>
#include <sstream>

namespace nav::render {
namespace {

/// Far beyond any probe, and with squares that stay exact.
constexpr double kFurthestMm = 1e7;

std::string text_of(const Eigen::Vector3d& v) {
  std::ostringstream text;
  text << v.x() << " " << v.y() << " " << v.z();
  return text.str();
}

bool is_place(const Eigen::Vector3d& mm) { return (mm.cwiseAbs().array() <= kFurthestMm).all(); }

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

Eigen::Vector3d unit_or_zero(const Eigen::Vector3d& v) {
  // Divided by the largest first: squares of finite numbers may not be finite.
  const double largest = v.cwiseAbs().maxCoeff();
  if (!v.allFinite() || !(largest > 0)) return Eigen::Vector3d::Zero();
  return (v / largest).normalized();
}

}  // namespace

Result<void> validate(const ScanGeometry& scan, const VoxelGrid& grid) {
  return std::visit([&](const auto& s) { return check(s, grid); }, scan);
}

Eigen::Vector3d scan_direction(const ScanGeometry& scan, const VoxelGrid& grid, int i, int j,
                               int k) {
  if (const auto* parallel = std::get_if<ParallelScan>(&scan)) {
    return unit_or_zero(parallel->into_ct.v);
  }
  if (const auto* fan = std::get_if<FanScan>(&scan)) {
    return unit_or_zero(grid.at({double(i), double(j), double(k)}).mm - fan->apex_ct.mm);
  }
  const std::size_t at = (static_cast<std::size_t>(k) * static_cast<std::size_t>(grid.size[1]) +
                          static_cast<std::size_t>(j)) *
                             static_cast<std::size_t>(grid.size[0]) +
                         static_cast<std::size_t>(i);
  return unit_or_zero((*std::get<VoxelScan>(scan).into_ct)[at].cast<double>());
}

}  // namespace nav::render
