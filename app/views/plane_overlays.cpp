// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/plane_overlays.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "app/views/overlay.hpp"

namespace nav::app {
namespace {

using render::Canvas;

constexpr Rgba8 kMarkColour = render::rgb8(0x9aa5b0);
constexpr Rgba8 kTargetColour = render::rgb8(0xffd94a);

/// Largest distance from the plane at which a needle is drawn in it, mm: about half the thickness
/// of a beam.
constexpr double kSliceHalfMm = 2;

/// Marks the point where the needle crosses the plane: a dot for its shaft, a ring for its path
/// ahead.
void draw_crossing(Canvas& canvas, const PlaneView& view, const Eigen::Vector3d& hub,
                   const Eigen::Vector3d& tip, const Eigen::Vector3d& ahead) {
  const auto mark = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius,
                        double width) {
    const bool in_plane = std::max(std::abs(a.z()), std::abs(b.z())) <= kSliceHalfMm;
    if (in_plane || (a.z() > 0) == (b.z() > 0)) return;
    const Eigen::Vector3d there = a + (b - a) * (a.z() / (a.z() - b.z()));
    const Eigen::Vector2d p = view.pixel_of(there.head<2>());
    if (view.contains(p)) canvas.circle(p, radius, width, kNeedleColour);
  };
  mark(hub, tip, 2, 4);
  mark(tip, ahead, 5, 1.5);
}

/// Draws a segment in short pieces, so that nothing leaves the view. reach_mm: pieces farther from
/// the plane are left out. dashed: with gaps.
void draw_pieces(Canvas& canvas, const PlaneView& view, const Eigen::Vector3d& a,
                 const Eigen::Vector3d& b, double reach_mm, double width, bool dashed,
                 Rgba8 colour) {
  constexpr int kPieces = 150;
  for (int i = 0; i < kPieces; ++i) {
    if (dashed && i / 4 % 2 == 1) continue;
    const Eigen::Vector3d from = a + (b - a) * i / kPieces;
    const Eigen::Vector3d to = a + (b - a) * (i + 1) / kPieces;
    if (std::abs(from.z()) > reach_mm || std::abs(to.z()) > reach_mm) continue;
    const Eigen::Vector2d p = view.pixel_of(from.head<2>());
    const Eigen::Vector2d q = view.pixel_of(to.head<2>());
    if (view.contains(p) && view.contains(q)) canvas.line(p, q, width, colour);
  }
}

/// The planned path where it meets the plane: a line where it lies in it, a square where it only
/// crosses it.
void draw_path(Canvas& canvas, const PlaneView& view, const Eigen::Vector3d& entry,
               const Eigen::Vector3d& target) {
  draw_pieces(canvas, view, entry, target, kSliceHalfMm, 1.5, false, kPathColour);
  const bool in_plane = std::max(std::abs(entry.z()), std::abs(target.z())) <= kSliceHalfMm;
  if (in_plane || (entry.z() > 0) == (target.z() > 0)) return;
  const Eigen::Vector3d there = entry + (target - entry) * (entry.z() / (entry.z() - target.z()));
  const Eigen::Vector2d p = view.pixel_of(there.head<2>());
  if (!view.contains(p)) return;
  constexpr double kHalf = 4;
  using Vec2 = Eigen::Vector2d;
  const std::array<Vec2, 4> corners{p + Vec2(-kHalf, -kHalf), p + Vec2(kHalf, -kHalf),
                                    p + Vec2(kHalf, kHalf), p + Vec2(-kHalf, kHalf)};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    canvas.line(corners[i], corners[(i + 1) % corners.size()], 1.5, kPathColour);
  }
}

}  // namespace

Point<frames::Image> marked_corner(const UltrasoundImage& frame) {
  return frame.grid.at(frame.pixels.width() - 1, 0);
}

void draw_depth_marks(Canvas& canvas, const PlaneView& view, const UltrasoundImage& frame,
                      int size) {
  constexpr int kFewMarks = 60;  // Depth in mm up to which every second mark has a number.
  const double deepest = view.origin_mm.y() + view.height * view.mm_per_px;
  const int numbered = deepest > kFewMarks ? 50 : 20;
  for (int depth = 0; depth < deepest && depth < 1000; depth += 10) {
    const double y = view.pixel_of({0, depth}).y();
    const bool has_number = depth > 0 && depth % numbered == 0;
    const double length = has_number ? 10 : 5;
    canvas.line({view.x + view.width - 1.0 - length, y}, {view.x + view.width - 1.0, y}, 1,
                kMarkColour);
    if (!has_number) continue;
    const std::string words = std::to_string(depth) + " mm";
    const int base = static_cast<int>(y) + size / 3;
    if (base < view.y + 2 * size || base > view.y + view.height - size / 2) continue;
    canvas.outlined_text(view.x + view.width - 14 - canvas.text_width(size, words), base, size,
                         words, kOverlayText);
  }
  const Eigen::Vector2d dot = view.pixel_of(marked_corner(frame).mm.head<2>());
  canvas.circle({std::min(dot.x(), view.x + view.width - 18.0), std::max(dot.y(), view.y + 8.0)}, 2,
                4, kNeedleColour);
}

void draw_in_plane(Canvas& canvas, const PlaneView& view, const PanelContext& context) {
  if (context.epoch.ct_from_image) {
    draw_in_plane(canvas, view, *context.epoch.ct_from_image, context);
  }
}

void draw_in_plane(Canvas& canvas, const PlaneView& view,
                   const Transform<frames::Ct, frames::Image>& ct_from_image,
                   const PanelContext& context) {
  const session::Epoch& epoch = context.epoch;
  const auto image_from_ct = ct_from_image.inverse();
  if (context.plan) {
    const Eigen::Vector3d target = (image_from_ct * context.plan->target_ct).mm;
    const auto ring = [&](double r, double width) {
      const double cut = r * r - target.z() * target.z();
      if (!(cut > 0)) return;
      canvas.circle(view.pixel_of(target.head<2>()), std::sqrt(cut) / view.mm_per_px, width,
                    kTargetColour);
    };
    ring(context.plan->target_radius_mm, 1.5);
    if (context.plan->margin_mm > 0) {
      ring(context.plan->target_radius_mm + context.plan->margin_mm, 0.7);
    }
  }
  if (context.plan) {
    draw_path(canvas, view, (image_from_ct * context.plan->entry_ct).mm,
              (image_from_ct * context.plan->target_ct).mm);
  }
  if (!epoch.ct_from_needle || epoch.needle.state > SafetyState::kDegraded) return;
  const auto image_from_needle = image_from_ct * *epoch.ct_from_needle;
  const Eigen::Vector3d tip = (image_from_needle * Point<frames::Needle>{{0, 0, 0}}).mm;
  const Eigen::Vector3d hub =
      (image_from_needle * Point<frames::Needle>{{0, 0, -context.needle_length_mm}}).mm;
  constexpr double kAheadMm = 150;
  const Eigen::Vector3d ahead = (image_from_needle * Point<frames::Needle>{{0, 0, kAheadMm}}).mm;
  draw_pieces(canvas, view, hub, tip, kSliceHalfMm, 2, false, kNeedleColour);
  draw_pieces(canvas, view, tip, ahead, kSliceHalfMm, 1, true, kNeedleColour);
  draw_crossing(canvas, view, hub, tip, ahead);
}

void draw_path_onto(Canvas& canvas, const PlaneView& view,
                    const Transform<frames::Ct, frames::Image>& ct_from_image,
                    const NeedlePlan& plan) {
  const auto image_from_ct = ct_from_image.inverse();
  const Eigen::Vector3d entry = (image_from_ct * plan.entry_ct).mm;
  const Eigen::Vector3d target = (image_from_ct * plan.target_ct).mm;
  draw_pieces(canvas, view, entry, target, std::numeric_limits<double>::infinity(), 1, true,
              kPathColour);
  const Eigen::Vector2d p = view.pixel_of(entry.head<2>());
  if (view.contains(p)) canvas.circle(p, 2, 4, kPathColour);
}

}  // namespace nav::app
