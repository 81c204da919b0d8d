// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <sstream>

#include "nav/index.hpp"
#include "render/features/scan_lines.hpp"
#include "render/parallel.hpp"

namespace nav::render::features {
namespace {

/// The plane of an ultrasound image in voxel indices. Gives the position of any voxel in the Image
/// frame, and its scan line.
class PlaneInGrid {
 public:
  PlaneInGrid(const VoxelGrid& grid, const SweepPlane& plane, double reach_mm)
      : plane_(plane), reach_mm_(reach_mm) {
    const auto image_from_ct = plane.ct_from_image.inverse();
    const Eigen::Matrix3d turn = image_from_ct.rotation().toRotationMatrix();
    per_index_ = turn * grid.directions * grid.spacing_mm.asDiagonal();
    at_zero_ = (image_from_ct * grid.at(Eigen::Vector3d::Zero())).mm;
    back_ = turn.transpose();
  }
  [[nodiscard]] Eigen::Vector3d image_mm(int i, int j, int k) const {
    return at_zero_ + per_index_ * Eigen::Vector3d(i, j, k);
  }
  /// Voxels [first, past) of row (j, k) within reach of the plane and between the image's corners.
  [[nodiscard]] std::array<int, 2> span(int j, int k, int size) const {
    const Eigen::Vector3d start = image_mm(0, j, k);
    const Eigen::Vector3d step = per_index_.col(0);
    double from = 0;
    double to = size - 1;
    const Eigen::Vector3d low(plane_.low_mm.x(), plane_.low_mm.y(), -reach_mm_);
    const Eigen::Vector3d high(plane_.high_mm.x(), plane_.high_mm.y(), reach_mm_);
    for (int a = 0; a < 3; ++a) {
      if (std::abs(step[a]) < 1e-12) {
        if (start[a] < low[a] || start[a] > high[a]) return {0, 0};
        continue;
      }
      const double one = (low[a] - start[a]) / step[a];
      const double other = (high[a] - start[a]) / step[a];
      from = std::max(from, std::min(one, other));
      to = std::min(to, std::max(one, other));
    }
    if (!(from <= to)) return {0, 0};
    return {static_cast<int>(std::ceil(from)), static_cast<int>(std::floor(to)) + 1};
  }
  struct Seen {
    double weight = 0;  ///< 0 means not insonified.
    Eigen::Vector3d away_ct;
    double depth_mm = 0;
  };
  [[nodiscard]] Seen see(int i, int j, int k) const {
    const Eigen::Vector3d p = image_mm(i, j, k);
    const double weight = 1 - std::abs(p.z()) / reach_mm_;
    if (!(weight > 0)) return {};
    if (!plane_.outline) return {weight, back_.col(1), p.y()};
    if (!plane_.outline->contains(p.head<2>())) return {};
    const Eigen::Vector2d from = p.head<2>() - plane_.outline->apex_mm;
    const double distance = from.norm();
    if (!(distance > 1e-9)) return {};
    const Eigen::Vector3d away(from.x() / distance, from.y() / distance, 0);
    return {weight, back_ * away, distance - plane_.outline->radius_min_mm};
  }

 private:
  const SweepPlane& plane_;
  double reach_mm_;
  Eigen::Matrix3d per_index_;
  Eigen::Vector3d at_zero_;
  Eigen::Matrix3d back_;
};

struct Sum {
  Eigen::Vector3d away = Eigen::Vector3d::Zero();
  double depth = 0;
  double weight = 0;
};

Result<void> check(std::span<const SweepPlane> planes, double reach_mm) {
  if (planes.empty()) {
    return Error{ErrorCode::kUsage, "scan lines of a sweep: expected images, found none"};
  }
  if (!(reach_mm > 0 && reach_mm <= 100)) {
    std::ostringstream text;
    text << "scan lines of a sweep: expected reach_mm in (0, 100], found " << reach_mm;
    return Error{ErrorCode::kUsage, text.str()};
  }
  for (std::size_t n = 0; n < planes.size(); ++n) {
    const Eigen::Vector2d extent = planes[n].high_mm - planes[n].low_mm;
    if (extent.x() > 0 && extent.y() > 0) continue;
    return Error{ErrorCode::kMalformedData,
                 "scan lines of a sweep: expected an extent above 0 x 0 mm of image " +
                     std::to_string(n) + ", found " + std::to_string(extent.x()) + " x " +
                     std::to_string(extent.y()) + " mm"};
  }
  return {};
}

}  // namespace

Result<ScanLines> compound_scan_lines(const VoxelGrid& grid, std::span<const SweepPlane> planes,
                                      double reach_mm, const RunOptions& run) {
  const std::string name = "scan lines of a sweep";
  if (auto ok = validate(grid, name); !ok) return ok.error();
  if (auto ok = check(planes, reach_mm); !ok) return ok.error();
  if (auto ok = check_memory(name, grid.voxel_count(), 8, run.memory_limit); !ok) return ok.error();
  std::vector<PlaneInGrid> placed;
  for (const SweepPlane& plane : planes) placed.emplace_back(grid, plane, reach_mm);
  std::vector<PackedDirection> away(grid.voxel_count());
  std::vector<float> depth(grid.voxel_count(), kUnknown);
  Steps steps(run, as_size(grid.size[2]));
  for_each_index(grid.size[2], run.threads, [&](int k) {
    if (!steps.next()) return;
    std::vector<Sum> row(as_size(grid.size[0]));
    for (int j = 0; j < grid.size[1]; ++j) {
      std::fill(row.begin(), row.end(), Sum{});
      for (const PlaneInGrid& plane : placed) {
        const auto [first, past] = plane.span(j, k, grid.size[0]);
        for (int i = first; i < past; ++i) {
          const auto seen = plane.see(i, j, k);
          if (!(seen.weight > 0)) continue;
          row[as_size(i)].away += seen.weight * seen.away_ct;
          row[as_size(i)].depth += seen.weight * seen.depth_mm;
          row[as_size(i)].weight += seen.weight;
        }
      }
      for (int i = 0; i < grid.size[0]; ++i) {
        const Sum& sum = row[as_size(i)];
        // Opposite directions cancel and give no scan line.
        if (!(sum.away.norm() > 1e-3 * sum.weight)) continue;
        away[offset_of(grid, i, j, k)] = PackedDirection::pack(sum.away.normalized());
        depth[offset_of(grid, i, j, k)] = static_cast<float>(sum.depth / sum.weight);
      }
    }
  });
  if (steps.stopped()) return cancelled(name);
  return ScanLines::per_voxel(grid, std::move(away), std::move(depth));
}

}  // namespace nav::render::features
