// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/scan_lines.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <sstream>

#include "nav/index.hpp"
#include "nav/positions.hpp"
#include "render/features/digest.hpp"
#include "render/parallel.hpp"

namespace nav::render::features {
namespace {

constexpr double kSteps = 32767;

double side_of(double v) { return v < 0 ? -1.0 : 1.0; }

template <class Found>
Error rejected_lines(const std::string& expected, const Found& found) {
  std::ostringstream text;
  text << "scan lines: expected " << expected << ", found " << found;
  return {ErrorCode::kUsage, text.str()};
}

Eigen::Vector3d undefined() { return Eigen::Vector3d::Constant(std::nan("")); }

}  // namespace

PackedDirection PackedDirection::pack(const Eigen::Vector3d& unit) {
  const double sum = unit.cwiseAbs().sum();
  if (!(sum > 0)) return {};
  Eigen::Vector2d p = unit.head<2>() / sum;
  if (unit.z() < 0) {
    p = Eigen::Vector2d((1 - std::abs(p.y())) * side_of(p.x()),
                        (1 - std::abs(p.x())) * side_of(p.y()));
  }
  const auto word = [](double v) {
    return static_cast<std::uint32_t>(
        static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(v * kSteps))));
  };
  return {word(p.x()) | word(p.y()) << 16};
}

Eigen::Vector3d PackedDirection::unpack() const {
  if (bits == kNone) return undefined();
  const auto value = [](std::uint32_t word) {
    return static_cast<std::int16_t>(static_cast<std::uint16_t>(word)) / kSteps;
  };
  const double x = value(bits & 0xffffU);
  const double y = value(bits >> 16);
  const double z = 1 - std::abs(x) - std::abs(y);
  if (z >= 0) return Eigen::Vector3d(x, y, z).normalized();
  return Eigen::Vector3d((1 - std::abs(y)) * side_of(x), (1 - std::abs(x)) * side_of(y), z)
      .normalized();
}

struct ScanLines::KnownDigest {
  std::once_flag once;
  std::string hex;
};

ScanLines::ScanLines() : digest_(std::make_shared<KnownDigest>()) {}

Result<ScanLines> ScanLines::parallel(const Direction<frames::Ct>& away,
                                      const Point<frames::Ct>& on_face) {
  if (!away.v.allFinite() || !(away.v.cwiseAbs().maxCoeff() > 1e-12)) {
    return rejected_lines("a finite direction that is not zero", away.v.transpose());
  }
  if (!is_place(on_face.mm)) return rejected_lines("a point within 1e7 mm", on_face.mm.transpose());
  ScanLines lines;
  lines.direction_ = away.v.stableNormalized();  // Squares of finite numbers may not be finite.
  lines.point_mm_ = on_face.mm;
  return lines;
}

Result<ScanLines> ScanLines::fan(const Point<frames::Ct>& apex, double face_radius_mm) {
  if (!is_place(apex.mm)) return rejected_lines("an apex within 1e7 mm", apex.mm.transpose());
  if (!(face_radius_mm >= 0 && face_radius_mm <= kFurthestMm)) {
    return rejected_lines("a face radius of 0 to 1e7 mm", face_radius_mm);
  }
  ScanLines lines;
  lines.kind_ = Kind::kFan;
  lines.point_mm_ = apex.mm;
  lines.face_radius_mm_ = face_radius_mm;
  return lines;
}

Result<ScanLines> ScanLines::per_voxel(const VoxelGrid& grid, std::vector<PackedDirection> away,
                                       std::vector<float> depth_mm) {
  if (const auto ok = validate(grid, "scan lines"); !ok) return ok.error();
  if (away.size() != grid.voxel_count() || depth_mm.size() != grid.voxel_count()) {
    return Error{ErrorCode::kMalformedData,
                 "scan lines: expected " + std::to_string(grid.voxel_count()) +
                     " directions and depths, found " + std::to_string(away.size()) + " and " +
                     std::to_string(depth_mm.size())};
  }
  ScanLines lines;
  lines.kind_ = Kind::kPerVoxel;
  lines.grid_ = grid;
  lines.away_ = std::make_shared<const std::vector<PackedDirection>>(std::move(away));
  lines.depth_ = std::make_shared<const std::vector<float>>(std::move(depth_mm));
  return lines;
}

Eigen::Vector3d ScanLines::away(const VoxelGrid& grid, int i, int j, int k) const {
  if (kind_ == Kind::kParallel) return direction_;
  if (kind_ == Kind::kPerVoxel) return (*away_)[offset_of(grid_, i, j, k)].unpack();
  const Eigen::Vector3d from = grid.at(Eigen::Vector3d(i, j, k)).mm - point_mm_;
  const double distance = from.norm();
  return distance > 1e-9 ? Eigen::Vector3d(from / distance) : undefined();
}

double ScanLines::depth_mm(const VoxelGrid& grid, int i, int j, int k) const {
  if (kind_ == Kind::kPerVoxel) {
    return static_cast<double>((*depth_)[offset_of(grid_, i, j, k)]);
  }
  const Eigen::Vector3d from = grid.at(Eigen::Vector3d(i, j, k)).mm - point_mm_;
  return kind_ == Kind::kParallel ? from.dot(direction_) : from.norm() - face_radius_mm_;
}

double ScanLines::before_mm(const VoxelGrid& grid, int i, int j, int k) const {
  if (kind_ != Kind::kFan) return std::numeric_limits<double>::infinity();
  return (grid.at(Eigen::Vector3d(i, j, k)).mm - point_mm_).norm();
}

std::optional<Eigen::Vector3d> ScanLines::common() const {
  if (kind_ != Kind::kParallel) return {};
  return direction_;
}

Result<void> ScanLines::check(const VoxelGrid& grid, const std::string& name) const {
  if (kind_ != Kind::kPerVoxel) return {};
  const bool same = grid_.size == grid.size && grid_.spacing_mm.isApprox(grid.spacing_mm, 1e-9) &&
                    (grid_.origin_mm - grid.origin_mm).norm() < 1e-6 &&
                    grid_.directions.isApprox(grid.directions, 1e-9);
  if (same) return {};
  const auto text = [](const VoxelGrid& g) {
    return std::to_string(g.size[0]) + " x " + std::to_string(g.size[1]) + " x " +
           std::to_string(g.size[2]);
  };
  return Error{ErrorCode::kUsage,
               name + ": expected scan-line directions on the grid of the volume (" + text(grid) +
                   "), found another grid (" + text(grid_) + ")"};
}

std::string ScanLines::digest() const {
  std::call_once(digest_->once, [this] {
    Digest digest;
    digest.add(static_cast<double>(kind_));
    for (int a = 0; a < 3; ++a) digest.add(direction_[a]);
    for (int a = 0; a < 3; ++a) digest.add(point_mm_[a]);
    digest.add(face_radius_mm_);
    if (kind_ == Kind::kPerVoxel) {
      digest.add(grid_);
      digest.add(std::as_bytes(std::span(*away_)));
      digest.add(std::as_bytes(std::span(*depth_)));
    }
    digest_->hex = digest.hex();
  });
  return digest_->hex;
}

Result<FeatureVolume> scan_depth(const VoxelGrid& grid, const ScanLines& lines,
                                 const RunOptions& run) {
  const std::string name = "depth along the scan line";
  if (auto ok = lines.check(grid, name); !ok) return ok.error();
  if (auto ok = check_memory(name, grid.voxel_count(), 4, run.memory_limit); !ok) return ok.error();
  std::vector<float> depth(grid.voxel_count());
  Steps steps(run, as_size(grid.size[2]));
  for_each_index(grid.size[2], run.threads, [&](int k) {
    if (!steps.next()) return;
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        depth[offset_of(grid, i, j, k)] = static_cast<float>(lines.depth_mm(grid, i, j, k));
      }
    }
  });
  if (steps.stopped()) return cancelled(name);
  return FeatureVolume{grid, std::make_shared<const std::vector<float>>(std::move(depth))};
}

}  // namespace nav::render::features
