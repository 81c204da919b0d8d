// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/bulls_eye.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "app/views/plane_overlays.hpp"

namespace nav::app {
namespace {

using Vec2 = Eigen::Vector2d;

constexpr Rgba8 kBullsEyeGround = render::rgb8(0x101418);
constexpr Rgba8 kRingColour = render::rgb8(0x5a6670);
constexpr Rgba8 kLesionColour = render::rgb8(0xffd94a);
constexpr int kLeastBullsEyePixels = 16;

/// Point in the plane of the target that the needle points at; absent for a needle that is nearly
/// parallel to the plane.
std::optional<Point<frames::Ct>> aim_of(const SliceGeometry& geometry,
                                        const Transform<frames::Ct, frames::Needle>& needle) {
  constexpr double kNearlyParallel = 0.1;
  const Eigen::Vector3d tip = (needle * Point<frames::Needle>{{0, 0, 0}}).mm;
  const Eigen::Vector3d axis = (needle * Direction<frames::Needle>{{0, 0, 1}}).v.normalized();
  const Eigen::Vector3d normal = geometry.plane.right.v.cross(geometry.plane.down.v);
  const double slope = axis.dot(normal);
  if (std::abs(slope) < kNearlyParallel) return std::nullopt;
  const double way_mm = (geometry.plane.centre_ct.mm - tip).dot(normal) / slope;
  return Point<frames::Ct>{tip + way_mm * axis};
}

}  // namespace

SliceGeometry bulls_eye_geometry(const NeedlePlan& plan,
                                 const Transform<frames::Ct, frames::Needle>& ct_from_needle,
                                 PixelSize size) {
  SliceGeometry geometry{
      .plane = render::oblique_slice(plan.target_ct, {plan.target_ct.mm - plan.entry_ct.mm}),
      .mm_per_px = 1,
      .size = size};
  const auto reach = [&](const Point<frames::Ct>& point) {
    const Eigen::Vector3d from = point.mm - plan.target_ct.mm;
    return std::max(std::abs(from.dot(geometry.plane.right.v)),
                    std::abs(from.dot(geometry.plane.down.v)));
  };
  double furthest =
      std::max(reach(ct_from_needle * Point<frames::Needle>{{0, 0, 0}}), plan.target_radius_mm);
  if (const auto aim = aim_of(geometry, ct_from_needle)) furthest = std::max(furthest, reach(*aim));
  double shown_mm = kBullsEyeRingsMm.back();
  for (std::size_t i = kBullsEyeRingsMm.size() - 1; i >= 1; --i) {
    if (furthest < 0.9 * kBullsEyeRingsMm[i]) shown_mm = kBullsEyeRingsMm[i];
  }
  const int smaller = std::max(1, std::min(size.width, size.height));
  geometry.mm_per_px = 2.3 * shown_mm / smaller;
  return geometry;
}

SliceDrawing draw_bulls_eye(const PanelContext& context, PixelSize size, double ratio) {
  render::Canvas canvas(size.width, size.height, kBullsEyeGround);
  const session::Epoch& epoch = context.epoch;
  if (size.width < kLeastBullsEyePixels || size.height < kLeastBullsEyePixels || !context.plan ||
      !epoch.guidance || !epoch.ct_from_needle) {
    return {canvas.image(), std::nullopt};
  }
  const auto& needle = *epoch.ct_from_needle;
  const SliceGeometry geometry = bulls_eye_geometry(*context.plan, needle, size);
  const auto at = [&](const Point<frames::Ct>& point) -> Vec2 {
    return geometry.pixel_of(point).head<2>();
  };
  const Vec2 centre = at(context.plan->target_ct);
  for (const double ring_mm : kBullsEyeRingsMm) {
    canvas.circle(centre, ring_mm / geometry.mm_per_px, ratio, kRingColour);
  }
  const double reach = 0.5 * std::max(size.width, size.height);
  canvas.line(centre - Vec2(reach, 0), centre + Vec2(reach, 0), ratio, kRingColour);
  canvas.line(centre - Vec2(0, reach), centre + Vec2(0, reach), ratio, kRingColour);
  canvas.circle(centre, context.plan->target_radius_mm / geometry.mm_per_px, 2 * ratio,
                kLesionColour);
  const Vec2 tip = at(needle * Point<frames::Needle>{{0, 0, 0}});
  if (const auto aim = aim_of(geometry, needle)) {
    const Vec2 there = at(*aim);
    canvas.line(tip, there, 1.5 * ratio, kNeedleColour, 4 * ratio);
    canvas.circle(there, 9 * ratio, 2 * ratio, kNeedleColour);
    canvas.line(there - Vec2(14 * ratio, 0), there + Vec2(14 * ratio, 0), ratio, kNeedleColour);
    canvas.line(there - Vec2(0, 14 * ratio), there + Vec2(0, 14 * ratio), ratio, kNeedleColour);
  }
  canvas.circle(tip, 2.5 * ratio, 5 * ratio, kNeedleColour);
  return {canvas.image(), geometry};
}

}  // namespace nav::app
