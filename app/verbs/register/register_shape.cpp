// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/register/register_shape.hpp"

#include "app/verbs/register/landmark_file.hpp"
#include "io/markups.hpp"
#include "io/surface_file.hpp"

namespace nav::app {
namespace {

constexpr double kPieceMm = 3;
constexpr double kVesselPieceMm = 1;
constexpr double kVesselPointsMm = 1.5;

template <class Frame>
std::vector<registration::CentreLine<Frame>> lines_of(
    const std::vector<std::vector<Eigen::Vector3d>>& groups) {
  std::vector<registration::CentreLine<Frame>> lines;
  for (const auto& group : groups) {
    lines.emplace_back();
    for (const auto& p : group) lines.back().push_back({p});
  }
  return lines;
}

/// Groups of points of a text or of a Markups file. \p of_tracker: they are of the patient's frame,
/// whose coordinates 3D Slicer takes as RAS.
Result<std::vector<std::vector<Eigen::Vector3d>>> read_groups(const std::filesystem::path& path,
                                                              bool of_tracker,
                                                              Diagnostics& diagnostics) {
  if (!io::is_markups_file(path)) return io::read_point_groups(path);
  const auto markups = io::read_markups(path);
  if (!markups) return markups.error();
  for (const Finding& finding : markups->findings) diagnostics.report("points", finding);
  std::vector<std::vector<Eigen::Vector3d>> groups;
  for (const auto& list : markups->lists) {
    std::vector<Eigen::Vector3d> group;
    for (const io::MarkupPoint& point : list) {
      if (point.placed) group.push_back(of_tracker ? point.ras_mm() : point.lps_mm);
    }
    if (!group.empty()) groups.push_back(std::move(group));
  }
  return groups;
}

Result<registration::Shape> read_shape(const ShapeFiles& files, Diagnostics& diagnostics) {
  if (!files.surface.empty()) {
    const auto mesh = io::read_surface(files.surface);
    if (!mesh) return mesh.error();
    return registration::surface_shape(*mesh, kPieceMm);
  }
  const auto groups = read_groups(files.centre_lines, false, diagnostics);
  if (!groups) return groups.error();
  return registration::curve_shape(lines_of<frames::Ct>(*groups), kVesselPieceMm,
                                   files.centre_lines.string());
}

Result<std::vector<Point<frames::Reference>>> read_points(const ShapeFiles& files,
                                                          Diagnostics& diagnostics) {
  const auto groups = read_groups(files.points, true, diagnostics);
  if (!groups) return groups.error();
  const auto lines = lines_of<frames::Reference>(*groups);
  std::vector<Eigen::Vector3d> all;
  for (const auto& line : lines) {
    for (const auto& point : line) all.push_back(point.mm);
  }
  if (const auto ok = check_unit(all, "points"); !ok) {
    return Error{ok.error().code, files.points.string() + ": " + ok.error().message};
  }
  if (files.surface.empty()) return registration::points_along(lines, kVesselPointsMm);
  std::vector<Point<frames::Reference>> points;
  for (const auto& line : lines) points.insert(points.end(), line.begin(), line.end());
  return points;
}

io::Json as_json(const registration::DistanceSummary& distances) {
  return {{"mean_mm", distances.mean_mm},
          {"median_mm", distances.median_mm},
          {"rms_mm", distances.rms_mm},
          {"p95_mm", distances.p95_mm}};
}

io::Json as_json(const registration::ShapeRival& rival) {
  return {{"mean_mm", rival.mean_mm},
          {"evidence", json_number(rival.evidence)},
          {"apart_mm", rival.apart_mm}};
}

/// Null if a direction slides.
io::Json as_json(const std::optional<registration::ShapeEvidence>& evidence) {
  if (!evidence) return nullptr;
  const auto& [noise, strain, rivals] = *evidence;
  io::Json json = {{"noise_mm", noise.sigma_mm},
                   {"rough_mm", noise.rough_mm ? io::Json(*noise.rough_mm) : io::Json(nullptr)},
                   {"independent_points", noise.independent_points},
                   {"scale", strain.scale},
                   {"scale_sigma", json_number(strain.scale_sigma)},
                   {"strain_evidence", json_number(strain.evidence)},
                   {"shared_distance_mm", strain.shared_mm},
                   {"shared_distance_sigma_mm", json_number(strain.shared_sigma_mm)},
                   {"own_mirror_image", rivals.own_mirror_image},
                   {"mirrored", rivals.mirrored ? as_json(*rivals.mirrored) : io::Json(nullptr)}};
  json["turned"] = io::Json::array();
  for (const auto& rival : rivals.turned) {
    json["turned"].push_back(as_json(rival));
    json["turned"].back()["turned_deg"] = rival.turned_deg;
  }
  return json;
}

}  // namespace

Result<registration::ShapeRegistration> register_shape_files(
    const ShapeFiles& files, const Transform<frames::Ct, frames::Reference>& start,
    Diagnostics& diagnostics) {
  if (files.surface.empty() == files.centre_lines.empty()) {
    return Error{ErrorCode::kUsage,
                 std::string("--points: expected one of --surface and --centre-lines, found ") +
                     (files.surface.empty() ? "neither" : "both")};
  }
  const auto shape = read_shape(files, diagnostics);
  if (!shape) return shape.error();
  const auto points = read_points(files, diagnostics);
  if (!points) return points.error();
  const auto field = registration::ShapeField::create(*shape);
  if (!field) return field.error();
  auto result = registration::register_points(*points, *field, start);
  if (!result) {
    return Error{result.error().code, files.points.string() + ": " + result.error().message};
  }
  return result;
}

io::Json json_of(const registration::ShapeRegistration& result,
                 const registration::Decision& decision, const Point<frames::Ct>& target) {
  io::Json json = json_of(decision);
  json["points"] = result.points;
  json["trimmed"] = result.trimmed;
  json["distance_before"] = as_json(result.before);
  json["distance"] = as_json(result.after);
  json["scale_mm"] = result.scale_mm;
  json["discrepancy_mm"] = json_number(result.discrepancy_mm);
  json["iterations"] = result.iterations;
  json["converged"] = result.converged;
  json["margin"] = result.margin ? json_number(*result.margin) : io::Json(nullptr);
  json["sliding"] = io::Json::array();
  for (const auto& one : result.sliding) json["sliding"].push_back(one.description);
  json["predicted_target_error_rms_mm"] = json_number(result.tre_rms_mm(target));
  json["evidence"] = as_json(result.evidence);
  json[pose_key(decision)] = json_of(result.ct_from_reference.matrix());
  return json;
}

}  // namespace nav::app
