// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/shape.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "nav/check.hpp"

namespace nav::registration {
namespace {

constexpr double kMinSpacingMm = 0.1;
constexpr double kMaxSpacingMm = 20;
constexpr std::size_t kMaxElements = std::size_t{1} << 24;
constexpr double kNoLengthMm = 1e-9;

Error malformed(const std::string& name, const std::string& expected, const std::string& found) {
  return {ErrorCode::kMalformedData, name + ": expected " + expected + ", found " + found};
}

Result<void> check_spacing(const std::string& name, double spacing_mm) {
  if (spacing_mm >= kMinSpacingMm && spacing_mm <= kMaxSpacingMm) return {};
  return Error{ErrorCode::kUsage,
               name + ": spacing_mm: expected 0.1 to 20, found " + std::to_string(spacing_mm)};
}

/// Centres of the n² small triangles that a triangle divides into.
void add_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                  const Eigen::Vector3d& normal, int n, std::vector<ShapeElement>& out) {
  const Eigen::Vector3d u = (b - a) / n;
  const Eigen::Vector3d v = (c - a) / n;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      out.push_back({a + (i + 1.0 / 3) * u + (j + 1.0 / 3) * v, normal});
      if (i + j + 1 < n) out.push_back({a + (i + 2.0 / 3) * u + (j + 2.0 / 3) * v, normal});
    }
  }
}

}  // namespace

Result<Shape> surface_shape(const TriangleMesh& mesh, double spacing_mm) {
  if (const auto ok = check_spacing(mesh.name, spacing_mm); !ok) return ok.error();
  Shape shape{ShapeKind::kSurface, {}, spacing_mm, mesh.name};
  const auto count = static_cast<int>(mesh.points_mm.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [i, j, k] = mesh.triangles[t];
    const std::string what = "triangle " + std::to_string(t);
    if (std::min({i, j, k}) < 0 || std::max({i, j, k}) >= count) {
      return malformed(mesh.name, what + " to use points 0 to " + std::to_string(count - 1),
                       "others");
    }
    const Eigen::Vector3d& a = mesh.points_mm[static_cast<std::size_t>(i)];
    const Eigen::Vector3d& b = mesh.points_mm[static_cast<std::size_t>(j)];
    const Eigen::Vector3d& c = mesh.points_mm[static_cast<std::size_t>(k)];
    const Eigen::Vector3d cross = (b - a).cross(c - a);
    if (!cross.allFinite() || !a.allFinite()) {
      return malformed(mesh.name, what + " to have finite points", "NaN or Inf");
    }
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    if (cross.norm() <= kNoLengthMm * longest) continue;
    const double parts = std::max(1.0, std::ceil(longest / spacing_mm));
    if (static_cast<double>(shape.elements.size()) + parts * parts > kMaxElements) {
      return malformed(mesh.name, "at most 2^24 pieces of " + std::to_string(spacing_mm) + " mm",
                       "more");
    }
    add_triangle(a, b, c, cross.normalized(), static_cast<int>(parts), shape.elements);
  }
  if (shape.elements.empty()) return malformed(mesh.name, "triangles with an area", "none");
  return shape;
}

Result<Shape> curve_shape(const std::vector<CentreLine<frames::Ct>>& lines, double spacing_mm,
                          const std::string& name) {
  if (const auto ok = check_spacing(name, spacing_mm); !ok) return ok.error();
  Shape shape{ShapeKind::kCurve, {}, spacing_mm, name};
  for (const auto& line : lines) {
    for (std::size_t i = 1; i < line.size(); ++i) {
      const Eigen::Vector3d& a = line[i - 1].mm;
      const Eigen::Vector3d along = line[i].mm - a;
      if (!along.allFinite()) return malformed(name, "finite points", "NaN or Inf");
      const double length = along.norm();
      if (length <= kNoLengthMm) continue;
      const double parts = std::ceil(length / spacing_mm);
      if (static_cast<double>(shape.elements.size()) + parts > kMaxElements) {
        return malformed(name, "at most 2^24 pieces of " + std::to_string(spacing_mm) + " mm",
                         "more");
      }
      for (int part = 0; part < static_cast<int>(parts); ++part) {
        shape.elements.push_back({a + (part + 0.5) / parts * along, along / length});
      }
    }
  }
  if (shape.elements.empty()) return malformed(name, "centre lines with a length", "none");
  return shape;
}

std::vector<Point<frames::Reference>> points_along(
    const std::vector<CentreLine<frames::Reference>>& lines, double spacing_mm) {
  NAV_CHECK(spacing_mm > 0, spacing_mm);
  std::vector<Point<frames::Reference>> points;
  for (const auto& line : lines) {
    if (line.empty()) continue;
    points.push_back(line.front());
    for (std::size_t i = 1; i < line.size(); ++i) {
      const Eigen::Vector3d along = line[i].mm - line[i - 1].mm;
      constexpr double kMostParts = 1e6;  // Limit for one step; no recording has a longer one.
      const double needed = std::min(std::ceil(along.norm() / spacing_mm), kMostParts);
      const int parts = std::max(1, static_cast<int>(needed));
      for (int part = 1; part <= parts; ++part) {
        points.push_back({line[i - 1].mm + static_cast<double>(part) / parts * along});
      }
    }
  }
  return points;
}

}  // namespace nav::registration
