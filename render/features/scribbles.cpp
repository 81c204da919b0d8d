// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/scribbles.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace nav::render::features {
namespace {

Result<void> check_numbers(const Stroke& stroke) {
  const auto reject = [](const std::string& expected, const auto& found) {
    std::ostringstream text;
    text << "scribble: expected " << expected << ", found " << found;
    return Error{ErrorCode::kUsage, text.str()};
  };
  if (stroke.points.empty()) return reject("at least one point", "none");
  for (const auto& p : stroke.points) {
    if (!(p.mm.cwiseAbs().array() <= Stroke::kFurthestMm).all()) {
      return reject("points within 1e6 mm", p.mm.transpose());
    }
  }
  const Eigen::Vector3d& normal = stroke.plane_normal.v;
  if (!normal.allFinite() || !(normal.cwiseAbs().maxCoeff() > 1e-12)) {
    return reject("a finite plane normal that is not zero", normal.transpose());
  }
  if (!(stroke.radius_mm > 0 && stroke.radius_mm <= 1000)) {
    return reject("radius_mm in (0, 1000]", stroke.radius_mm);
  }
  if (!(stroke.half_thickness_mm >= 0 && stroke.half_thickness_mm <= 1000)) {
    return reject("half_thickness_mm in [0, 1000]", stroke.half_thickness_mm);
  }
  return {};
}

double distance_to_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& from,
                           const Eigen::Vector3d& to) {
  const Eigen::Vector3d along = to - from;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - from).dot(along) / length2, 0.0, 1.0) : 0;
  return (p - from - t * along).norm();
}

Eigen::Vector3d unit_normal_of(const Stroke& stroke) {
  // Normalises stably, because squares of finite numbers may not be finite.
  return stroke.plane_normal.v.stableNormalized();
}

double half_thickness_of(const Stroke& stroke, const VoxelGrid& grid) {
  if (stroke.half_thickness_mm > 0) return stroke.half_thickness_mm;
  return 0.5 *
         (grid.directions.transpose() * unit_normal_of(stroke)).cwiseAbs().dot(grid.spacing_mm);
}

std::uint8_t bit_of(Paint paint) {
  return paint == Paint::kShow   ? ScribbleMask::kShowBit
         : paint == Paint::kHide ? ScribbleMask::kHideBit
                                 : std::uint8_t{0};
}

}  // namespace

Result<void> check(const Stroke& stroke, const VoxelGrid& grid) {
  if (const auto ok = check_numbers(stroke); !ok) return ok;
  constexpr double kRoundingMm = 1e-6;
  const Eigen::Vector3d normal = unit_normal_of(stroke);
  const double allowed_mm = half_thickness_of(stroke, grid);
  for (std::size_t n = 0; n < stroke.points.size(); ++n) {
    const Eigen::Vector3d& p = stroke.points[n].mm;
    const double off_mm = std::abs((p - stroke.points.front().mm).dot(normal));
    if (off_mm <= allowed_mm + kRoundingMm) continue;
    std::ostringstream text;
    text << "scribble: expected points within " << allowed_mm
         << " mm (half the thickness) of the slice through the first point, found point " << n + 1
         << " at (" << p.transpose() << "), " << off_mm << " mm away";
    return Error{ErrorCode::kUsage, text.str()};
  }
  return {};
}

ScribbleMask::ScribbleMask(const VoxelGrid& grid) : grid_(grid), bits_(grid.voxel_count()) {
  const auto ok = validate(grid, "scribbles");
  NAV_CHECK(ok.has_value());
}

Result<ScribbleMask::Painted> ScribbleMask::add(const Stroke& stroke) {
  if (const auto ok = check(stroke, grid_); !ok) return ok.error();
  const Eigen::Vector3d normal = unit_normal_of(stroke);
  const double thickness = half_thickness_of(stroke, grid_);
  Painted painted;
  for (std::size_t n = 0; n < stroke.points.size(); ++n) {
    const std::size_t next = std::min(n + 1, stroke.points.size() - 1);
    if (next == n && n > 0) break;
    add_segment(stroke, stroke.points[n].mm, stroke.points[next].mm, normal, thickness, painted);
  }
  return painted;
}

void ScribbleMask::add_segment(const Stroke& stroke, const Eigen::Vector3d& from,
                               const Eigen::Vector3d& to, const Eigen::Vector3d& normal,
                               double half_thickness, Painted& painted) {
  const Eigen::Vector3d a = grid_.index_of({from});
  const Eigen::Vector3d b = grid_.index_of({to});
  const Eigen::Vector3d reach = grid_.spacing_mm.cwiseInverse() * stroke.radius_mm;
  std::array<int, 3> first{};
  std::array<int, 3> last{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto n = static_cast<std::size_t>(axis);
    const double most = grid_.size[n] - 1;
    // Clamps before rounding, so that strokes far outside do not overflow.
    first[n] = static_cast<int>(
        std::ceil(std::clamp(std::min(a[axis], b[axis]) - reach[axis], 0.0, most + 1)));
    last[n] = static_cast<int>(
        std::floor(std::clamp(std::max(a[axis], b[axis]) + reach[axis], -1.0, most)));
  }
  const std::uint8_t bit = bit_of(stroke.paint);
  for (int k = first[2]; k <= last[2]; ++k) {
    for (int j = first[1]; j <= last[1]; ++j) {
      for (int i = first[0]; i <= last[0]; ++i) {
        const Eigen::Vector3d p = grid_.at(Eigen::Vector3d(i, j, k)).mm;
        if (std::abs((p - stroke.points.front().mm).dot(normal)) > half_thickness) continue;
        if (distance_to_segment(p, from, to) > stroke.radius_mm) continue;
        std::uint8_t& voxel = bits_[offset_of(grid_, i, j, k)];
        painted.covers_any = true;
        painted.changed += voxel != bit ? 1 : 0;
        voxel = bit;
      }
    }
  }
}

void ScribbleMask::clear() { std::fill(bits_.begin(), bits_.end(), std::uint8_t{0}); }

ScribbleCounts count_scribbles(const ScribbleMask& mask, int predicates,
                               const std::function<std::uint32_t(std::size_t)>& predicates_at) {
  NAV_CHECK(predicates >= 1 && predicates <= 32, predicates);
  const auto n = static_cast<std::size_t>(predicates);
  ScribbleCounts counts{std::vector<std::uint64_t>(n), std::vector<std::uint64_t>(n)};
  for (std::size_t voxel = 0; voxel < mask.bits().size(); ++voxel) {
    const std::uint8_t bits = mask.bits()[voxel];
    if (bits == 0) continue;
    const std::uint32_t holds = predicates_at(voxel);
    auto& side = bits == ScribbleMask::kShowBit ? counts.shown : counts.hidden;
    for (std::size_t p = 0; p < n; ++p) side[p] += holds >> p & 1U;
  }
  return counts;
}

}  // namespace nav::render::features
