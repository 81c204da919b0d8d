// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/bone/bone_registration.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "nav/check.hpp"
#include "registration/shape/shape_solver.hpp"

namespace nav::registration {
namespace {

constexpr std::size_t kLeastBonePoints = 20;
constexpr double kFineFieldMm = 2;
constexpr double kCoarseFieldMm = 4;
constexpr double kFieldMarginMm = 40;
constexpr double kMostFineNodes = 4e6;
constexpr double kOtherSideMm = 3;
// A twist turns rather than shifts if this is the share of its rotation at the points' distance.
constexpr double kTurnsRad = 5e-3;

Result<ShapeField> field_of(const Shape& shape) {
  Eigen::AlignedBox3d box;
  for (const ShapeElement& e : shape.elements) box.extend(e.point_mm);
  const Eigen::Vector3d sides = box.sizes().array() + 2 * kFieldMarginMm;
  const bool fine = sides.prod() / std::pow(kFineFieldMm, 3) <= kMostFineNodes;
  return ShapeField::create(
      shape, {.spacing_mm = fine ? kFineFieldMm : kCoarseFieldMm, .margin_mm = kFieldMarginMm});
}

/// Pieces that face some beam, of an even choice of the points, in a pose.
Shape facing(const Shape& surface, const std::vector<BonePoint>& points,
             const Transform<frames::Ct, frames::Reference>& pose, double most_rad) {
  // The beams of a sweep lie close together: one of each direction will do.
  std::vector<Eigen::Vector3d> beams;
  for (const BonePoint& one : points) {
    const Eigen::Vector3d beam = pose.rotation() * one.beam;
    const bool known =
        std::any_of(beams.begin(), beams.end(), [&](const auto& b) { return b.dot(beam) > 0.985; });
    if (!known) beams.push_back(beam);
  }
  Shape out{surface.kind, {}, surface.spacing_mm, surface.name};
  const double least = std::cos(most_rad);
  for (const ShapeElement& e : surface.elements) {
    const bool faces = std::any_of(beams.begin(), beams.end(),
                                   [&](const auto& b) { return -b.dot(e.axis) >= least; });
    if (faces) out.elements.push_back(e);
  }
  return out;
}

}  // namespace

std::vector<BonePoint> bone_points(const BoneOfSweep& bone, const Sweep& sweep,
                                   double least_confidence) {
  NAV_CHECK(bone.images.size() == sweep.frames().size(), bone.images.size());
  std::vector<BonePoint> out;
  for (std::size_t i = 0; i < bone.images.size(); ++i) {
    const auto& pose = sweep.frames()[i].reference_from_image;
    for (const BoneEcho& one : bone.images[i]) {
      if (one.confidence < least_confidence) continue;
      out.push_back({pose * Point<frames::Image>{{one.at_mm.x(), one.at_mm.y(), 0}},
                     pose.rotation() * Eigen::Vector3d(one.along.x(), one.along.y(), 0),
                     one.confidence});
    }
  }
  return out;
}

Result<BoneRegistration> register_bone(const BoneOfSweep& bone, const Sweep& sweep,
                                       const Shape& surface,
                                       const Transform<frames::Ct, frames::Reference>& start,
                                       const BoneRegistrationOptions& options,
                                       const std::function<bool()>& keep_going) {
  const std::vector<BonePoint> found = bone_points(bone, sweep, options.least_confidence);
  if (found.size() < kLeastBonePoints) {
    return Error{ErrorCode::kRefused,
                 "bone: expected at least 20 scan lines that meet bone, found " +
                     std::to_string(found.size()) + ": show more of the bone"};
  }
  std::vector<Point<frames::Reference>> points;
  for (const BonePoint& one : found) points.push_back(one.at);
  const Shape side = facing(surface, found, start, options.facing_rad);
  if (side.elements.empty()) {
    return Error{ErrorCode::kRefused,
                 surface.name +
                     ": no surface of bone faces the probe in the start pose: check the "
                     "start"};
  }
  const auto side_field = field_of(side);
  if (!side_field) return side_field.error();
  const auto whole_field = field_of(surface);
  if (!whole_field) return whole_field.error();
  auto near = register_points(points, *side_field, start, options.shape, keep_going);
  if (!near) return near.error();
  // Once more from there: the side is that of the start, which may have been turned.
  const auto side_found =
      field_of(facing(surface, found, near->ct_from_reference, options.facing_rad));
  if (!side_found) return side_found.error();
  auto result =
      register_points(points, *side_found, near->ct_from_reference, options.shape, keep_going);
  if (!result) return result.error();
  result->before = near->before;
  const auto whole =
      register_points(points, *whole_field, result->ct_from_reference, options.shape, keep_going);
  if (!whole) return whole.error();
  BoneRegistration out{.shape = std::move(*result),
                       .echoes = found.size(),
                       .share = bone.share(),
                       .from_whole_mm = 0};
  out.from_whole_mm =
      points_apart_mm(out.shape.some_points, out.shape.ct_from_reference, whole->ct_from_reference);
  // A direction that slides on either surface does so.
  if (out.shape.sliding.empty()) out.shape.sliding = whole->sliding;
  out.shape.evidence = out.shape.sliding.empty() ? whole->evidence : std::nullopt;
  return out;
}

Decision decide(const BoneRegistration& result, const ShapeLimits& limits,
                const Point<frames::Ct>& target, const std::optional<KnownPose>& known,
                const std::optional<double>& given_sigma_mm) {
  Decision decision = decide(result.shape, limits, target, kShapeWarnings, known, given_sigma_mm);
  bool slides = false;
  bool turns = false;
  for (const SlidingDirection& one : result.shape.sliding) {
    const bool rotation = one.twist.head<3>().norm() > kTurnsRad;
    (rotation ? turns : slides) = true;
  }
  if (slides) decision.reject("the CT slides along the bone: show an end or a joint of it");
  if (turns) {
    decision.reject("the CT turns about the bone: show an end or a joint, or more sides of it");
  }
  if (decision.accepted && !known) {
    decision.warnings.emplace_back(
        "bone alone does not tell its level and patient: check both, or give landmarks or "
        "--start-within");
  }
  if (!(result.from_whole_mm <= kOtherSideMm)) {
    std::ostringstream text;
    text.precision(2);
    text << "the echoes fit another side of the bone as well, " << result.from_whole_mm
         << " mm away: give a better start, or show more of the bone";
    decision.reject(text.str());
  }
  return decision;
}

}  // namespace nav::registration
