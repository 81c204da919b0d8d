// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/describe_shapes.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <map>
#include <numbers>
#include <utility>

#include "app/report.hpp"
#include "app/verbs/register/landmark_file.hpp"
#include "io/markups.hpp"
#include "io/surface_file.hpp"
#include "io/transform_file.hpp"

namespace nav::app {
namespace {

io::Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Bounding box of points as {low, high}; null without points.
io::Json box_of(const std::vector<Eigen::Vector3d>& points) {
  if (points.empty()) return {};
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : points) box.extend(point);
  return {vector_json(box.min()), vector_json(box.max())};
}

/// Number of edges that do not belong to exactly two triangles. A closed surface has none.
std::int64_t open_edges(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> uses;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(triangle[i], triangle[(i + 1) % 3]);
      ++uses[{low, high}];
    }
  }
  return std::ranges::count_if(uses, [](const auto& edge) { return edge.second != 2; });
}

}  // namespace

Result<io::Json> describe_markups(const std::filesystem::path& path, Console& console) {
  const auto markups = io::read_markups(path);
  if (!markups) return markups.error();
  for (const Finding& finding : markups->findings) console.report("markups", finding);
  io::Json lists = io::Json::array();
  std::vector<Eigen::Vector3d> placed;
  for (const auto& list : markups->lists) {
    io::Json points = io::Json::array();
    for (const io::MarkupPoint& point : list) {
      points.push_back({{"name", point.name},
                        {"lps_mm", point.placed ? vector_json(point.lps_mm) : io::Json()}});
      if (point.placed) placed.push_back(point.lps_mm);
    }
    lists.push_back(std::move(points));
  }
  return io::Json{{"kind", "markups"},
                  {"coordinate_system", "LPS"},
                  {"lists", std::move(lists)},
                  {"box_mm", box_of(placed)}};
}

Result<io::Json> describe_transform(const std::filesystem::path& path, Console& console) {
  const auto ct_from_reference = io::read_ct_from_reference(path);
  if (!ct_from_reference) return ct_from_reference.error();
  if (const auto rigid = rigid_from_matrix<frames::Ct, frames::Reference>(*ct_from_reference);
      !rigid) {
    console.report(Severity::kWarning, "transform",
                   path.string() + ": places no CT: " + rigid.error().message);
  }
  const Eigen::Matrix3d linear = ct_from_reference->topLeftCorner<3, 3>();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
  io::Json json{{"kind", "transform"},
                {"ct_from_reference_mm", json_of(*ct_from_reference)},
                {"mirrors", linear.determinant() < 0},
                {"scales", vector_json(svd.singularValues())},
                {"shift_mm", vector_json(ct_from_reference->topRightCorner<3, 1>())}};
  const Eigen::Matrix3d turn = svd.matrixU() * svd.matrixV().transpose();
  constexpr double kDegrees = 180 / std::numbers::pi;
  json["turn_deg"] =
      linear.determinant() < 0 ? io::Json() : io::Json(Eigen::AngleAxisd(turn).angle() * kDegrees);
  return json;
}

Result<io::Json> describe_surface(const std::filesystem::path& path) {
  const auto mesh = io::read_surface(path);
  if (!mesh) return mesh.error();
  return io::Json{{"kind", "surface"},
                  {"coordinate_system", "LPS"},
                  {"points", mesh->points_mm.size()},
                  {"triangles", mesh->triangles.size()},
                  {"open_edges", open_edges(*mesh)},
                  {"box_mm", box_of(mesh->points_mm)}};
}

Result<io::Json> describe_landmarks(const std::filesystem::path& path) {
  const auto list = read_landmarks(path);
  if (!list) return list.error();
  std::vector<Eigen::Vector3d> reference, ct;
  io::Json names = io::Json::array();
  for (const registration::LandmarkPair& pair : list->pairs) {
    names.push_back(pair.name);
    reference.push_back(pair.reference.mm);
    ct.push_back(pair.ct.mm);
  }
  return io::Json{{"kind", "landmarks"},
                  {"names", std::move(names)},
                  {"sigmas_given", list->sigmas_given},
                  {"reference_box_mm", box_of(reference)},
                  {"ct_box_mm", box_of(ct)}};
}

}  // namespace nav::app
