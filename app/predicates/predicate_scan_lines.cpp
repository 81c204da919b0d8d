// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicate_scan_lines.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <stop_token>

#include "app/interrupt.hpp"
#include "io/json_member.hpp"
#include "io/scan_line_file.hpp"
#include "render/features/scan_lines.hpp"
#include "tracking/reconstruction/reconstruction.hpp"

namespace nav::app {
namespace {

using render::features::SweepPlane;
using CtFromImage = Transform<frames::Ct, frames::Image>;

constexpr int kScanLinesVersion = 1;

constexpr double kFurthestLineMm = 1e6;

struct ScannedPlanes {
  double reach_mm = 1;
  std::vector<SweepPlane> planes;
};

Eigen::Vector2d read_point(io::JsonMember& member, const char* key) {
  std::vector<double> numbers;
  member.numbers(key, 2, numbers);
  if (numbers.empty()) member.fail(key, "2 numbers", io::Json());
  for (const double x : numbers) {
    if (!(std::abs(x) <= kFurthestLineMm)) member.fail(key, "numbers within 1e6 mm", x);
  }
  return numbers.empty() ? Eigen::Vector2d::Zero() : Eigen::Vector2d(numbers[0], numbers[1]);
}

std::optional<SectorOutline> read_sector(io::JsonMember& plane, const std::string& at,
                                         std::optional<Error>& error) {
  const io::Json* json = plane.any("sector");
  if (json == nullptr || error) return {};
  io::JsonMember member(*json, at + ".sector", error);
  SectorOutline sector{read_point(member, "apex_mm"), 0, 0, 0};
  member.number("radius_min_mm", sector.radius_min_mm);
  member.number("radius_max_mm", sector.radius_max_mm);
  member.angle("half_angle_deg", sector.half_angle_rad);
  member.finish();
  if (!(sector.radius_min_mm >= 0 && sector.radius_min_mm <= kFurthestLineMm)) {
    member.fail("radius_min_mm", "a number in [0, 1e6]", sector.radius_min_mm);
  }
  if (!(sector.radius_max_mm > sector.radius_min_mm && sector.radius_max_mm <= kFurthestLineMm)) {
    member.fail("radius_max_mm", "more than radius_min_mm, at most 1e6", sector.radius_max_mm);
  }
  if (!(sector.half_angle_rad > 0 && sector.half_angle_rad <= M_PI)) {
    member.fail("half_angle_deg", "a number in (0, 180]", sector.half_angle_rad / io::kRadPerDeg);
  }
  return sector;
}

CtFromImage read_pose(io::JsonMember& plane, const std::string& at, std::optional<Error>& error) {
  const CtFromImage none{Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()};
  std::vector<double> numbers;
  plane.numbers("ct_from_image", 16, numbers);
  if (numbers.empty()) plane.fail("ct_from_image", "16 numbers, row by row", io::Json());
  for (const double x : numbers) {
    if (!(std::abs(x) <= kFurthestLineMm)) plane.fail("ct_from_image", "numbers within 1e6", x);
  }
  if (error) return none;
  const Eigen::Matrix4d matrix =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  const auto pose = rigid_from_matrix<frames::Ct, frames::Image>(matrix);
  if (pose) return *pose;
  error = Error{pose.error().code, at + ".ct_from_image: " + pose.error().message};
  return none;
}

Result<ScannedPlanes> read_scanned_planes(const std::filesystem::path& path) {
  constexpr std::uint64_t kMostBytes = 256 << 20;
  const auto root = io::read_json(path, kMostBytes);
  if (!root) return root.error();
  const std::string name = path.string();
  std::optional<Error> error;
  io::JsonMember member(*root, name, error);
  member.version("sonde_scan_lines", kScanLinesVersion);
  ScannedPlanes scanned;
  member.number("reach_mm", scanned.reach_mm);
  if (!(scanned.reach_mm > 0 && scanned.reach_mm <= 100)) {
    member.fail("reach_mm", "a number in (0, 100]", scanned.reach_mm);
  }
  member.list("planes", [&](const io::Json& json, const std::string& at) {
    io::JsonMember plane(json, at, error);
    const CtFromImage pose = read_pose(plane, at, error);
    const Eigen::Vector2d low = read_point(plane, "low_mm");
    const Eigen::Vector2d high = read_point(plane, "high_mm");
    scanned.planes.push_back({pose, low, high, read_sector(plane, at, error)});
    plane.finish();
  });
  member.finish();
  if (!error && scanned.planes.empty()) member.fail("planes", "at least one", io::Json::array());
  if (error) return *error;
  return scanned;
}

bool any_defined(const render::features::ScanLines& lines, const VoxelGrid& grid) {
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (lines.away(grid, i, j, k).allFinite()) return true;
      }
    }
  }
  return false;
}

Point<frames::Ct> nearest_corner(const VoxelGrid& grid, const Eigen::Vector3d& away) {
  Point<frames::Ct> nearest = grid.at({0, 0, 0});
  for (int corner = 1; corner < 8; ++corner) {
    const Eigen::Vector3d index((corner & 1) * (grid.size[0] - 1),
                                (corner >> 1 & 1) * (grid.size[1] - 1),
                                (corner >> 2) * (grid.size[2] - 1));
    if ((grid.at(index).mm - nearest.mm).dot(away) < 0) nearest = grid.at(index);
  }
  return nearest;
}

/// Compounds scan lines on another thread, so that this thread can show progress and react to
/// Ctrl-C.
Result<render::features::ScanLines> compounded(const VoxelGrid& grid, const ScannedPlanes& sweep,
                                               int threads, Console& console) {
  const Interrupt interrupt;
  std::stop_source stop;
  std::atomic<double> done = 0;
  render::features::RunOptions run;
  run.threads = threads;
  run.stop = stop.get_token();
  run.progress = [&done](double share) { done = share; };
  console.begin("scan lines");
  auto lines = std::async(std::launch::async, [&] {
    return render::features::compound_scan_lines(grid, sweep.planes, sweep.reach_mm, run);
  });
  constexpr std::chrono::milliseconds kBetweenChecks(50);
  while (lines.wait_for(kBetweenChecks) != std::future_status::ready) {
    console.progress(done);
    if (interrupt.asked()) stop.request_stop();
  }
  auto found = lines.get();
  if (interrupt.asked())
    found = render::features::cancelled("scan lines");  // Ctrl-C may come at the very end.
  console.end(found ? "done" : interrupt.asked() ? "cancelled" : "rejected");
  return found;
}

}  // namespace

Point<frames::Ct> nearest_voxel(const StoredVolume& volume, const Eigen::Vector3d& away,
                                std::optional<std::int16_t> unknown) {
  const VoxelGrid& grid = volume.grid();
  if (!unknown) return nearest_corner(grid, away);
  const Eigen::Vector3d depth_step =
      (grid.directions.transpose() * away).cwiseProduct(grid.spacing_mm);
  double least = INFINITY;
  Eigen::Vector3d nearest = Eigen::Vector3d::Zero();
  std::size_t at = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (volume.values()[at++] == *unknown) continue;
        const double depth = depth_step.dot(Eigen::Vector3d(i, j, k));
        if (depth >= least) continue;
        least = depth;
        nearest = {static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
      }
    }
  }
  return std::isfinite(least) ? grid.at(nearest) : nearest_corner(grid, away);
}

Result<render::features::ScanLines> read_scan_lines(const std::filesystem::path& path,
                                                    const VoxelGrid& grid, int threads,
                                                    Console& console) {
  const auto sweep = read_scanned_planes(path);
  if (!sweep) return sweep.error();
  const auto named = [&](const Error& error) {
    return Error{error.code, path.string() + ": " + error.message};
  };
  const auto lines = compounded(grid, *sweep, threads, console);
  if (!lines) return named(lines.error());
  if (!any_defined(*lines, grid)) {
    return named({ErrorCode::kMalformedData,
                  "planes: expected images within reach_mm of a voxel, with directions that do not "
                  "cancel there, found none"});
  }
  return lines;
}

Result<std::optional<render::features::ScanLines>> scan_lines_beside(
    const std::filesystem::path& file, const StoredVolume& volume, Console& console) {
  using Found = std::optional<render::features::ScanLines>;
  const std::filesystem::path path = io::scan_lines_beside(file);
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return Found();
  const auto read = io::read_scan_line_file(path);
  if (!read) return read.error();
  if (read->lines.size() != volume.values().size() ||
      read->volume_digest != io::digest_of(volume)) {
    console.report(
        Severity::kWarning, "scan lines",
        path.string() + " belongs to other voxels than " + file.string() + ": it is not used");
    return Found();
  }
  std::vector<render::features::PackedDirection> away;
  std::vector<float> depth_mm;
  away.reserve(read->lines.size());
  depth_mm.reserve(read->lines.size());
  for (const ScanLineAtVoxel& line : read->lines) {
    using render::features::PackedDirection;
    away.push_back(line.defined() ? PackedDirection::pack(line.away()) : PackedDirection{});
    depth_mm.push_back(line.defined() ? static_cast<float>(line.depth_mm())
                                      : render::features::kUnknown);
  }
  auto lines =
      render::features::ScanLines::per_voxel(volume.grid(), std::move(away), std::move(depth_mm));
  if (!lines) return lines.error();
  console.report(Severity::kInfo, "scan lines", path.string() + " is used");
  return Found(*std::move(lines));
}

std::optional<int> unknown_of_reconstruction(const StoredVolume& volume, std::optional<int> given) {
  if (given ||
      std::ranges::find(volume.values(), tracking::kUnseenVoxel) == volume.values().end()) {
    return given;
  }
  return tracking::kUnseenVoxel;
}

Result<void> add_scan_lines(const std::filesystem::path& path, const VoxelGrid& grid, int threads,
                            render::PredicateScene& predicates, Console& console) {
  const auto lines = read_scan_lines(path, grid, threads, console);
  if (!lines) return lines.error();
  if (const auto ok = add_lines(*lines, grid, threads, predicates); !ok) {
    return Error{ok.error().code, path.string() + ": " + ok.error().message};
  }
  return {};
}

Result<void> add_lines(const render::features::ScanLines& lines, const VoxelGrid& grid, int threads,
                       render::PredicateScene& predicates) {
  render::features::RunOptions run;
  run.threads = threads;
  const auto depths = render::features::scan_depth(grid, lines, run);
  if (!depths) return depths.error();
  auto depth = render::FeatureVolume::create(grid, *depths->values, render::feature::kDepth);
  if (!depth) return depth.error();
  auto away = std::make_shared<std::vector<Eigen::Vector3f>>();
  away->reserve(grid.voxel_count());
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        away->push_back(lines.away(grid, i, j, k).cast<float>());
      }
    }
  }
  predicates.scan = render::VoxelScan{std::move(away)};
  predicates.features.volumes.insert_or_assign(render::feature::kDepth, *std::move(depth));
  return {};
}

}  // namespace nav::app
