// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/slice_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/views/plane_overlays.hpp"

namespace nav::app {
namespace {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;

constexpr Rgba8 kSliceBackground = render::rgb8(0x101418);
constexpr int kLeastSlicePixels = 16;
constexpr double kSliceMargin = 1.05;
constexpr double kLeastMmPerPx = 0.005;
constexpr double kMostMmPerPx = 100;
/// Extent of a needle slice that is not zoomed, mm.
constexpr double kNeedleExtentMm = 120;
/// Steps along the line of the plane, at which its outline is asked.
constexpr int kTraceSteps = 240;

/// Box around the CT in its own axes (LPS), mm.
Eigen::AlignedBox3d box_of(const VoxelGrid& grid) {
  Eigen::AlignedBox3d box;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 index;
    for (int axis = 0; axis < 3; ++axis) {
      const int last = grid.size[static_cast<std::size_t>(axis)] - 1;
      index[axis] = (corner >> axis & 1) != 0 ? last : 0;
    }
    box.extend(grid.at(index).mm);
  }
  return box;
}

bool is_small(PixelSize size) {
  return size.width < kLeastSlicePixels || size.height < kLeastSlicePixels;
}

bool shows_needle(const session::Epoch& epoch) {
  return epoch.ct_from_needle && epoch.needle.state <= SafetyState::kDegraded;
}

render::SlicePlane orthogonal_plane(SliceKind kind, const Point<frames::Ct>& through) {
  return kind == SliceKind::kAxial     ? render::axial_slice(through)
         : kind == SliceKind::kCoronal ? render::coronal_slice(through)
                                       : render::sagittal_slice(through);
}

Transform<frames::Ct, frames::Image> ct_from_slice(const render::SlicePlane& plane) {
  Eigen::Matrix3d axes;
  axes << plane.right.v, plane.down.v, plane.right.v.cross(plane.down.v);
  return {Eigen::Quaterniond(axes).normalized(), plane.centre_ct.mm};
}

/// The plane of a view that lies in the slice: its origin is the slice's centre.
PlaneView view_of(const SliceGeometry& geometry) {
  const Vec2 middle(0.5 * (geometry.size.width - 1), 0.5 * (geometry.size.height - 1));
  return {.x = 0,
          .y = 0,
          .width = geometry.size.width,
          .height = geometry.size.height,
          .origin_mm = -geometry.mm_per_px * middle,
          .mm_per_px = geometry.mm_per_px};
}

void draw_trace(render::Canvas& canvas, const SliceGeometry& geometry, const PanelContext& context,
                double ratio) {
  const session::Epoch& epoch = context.epoch;
  if (!epoch.frame || !epoch.ct_from_image || epoch.plane.state > SafetyState::kDegraded) return;
  const UltrasoundImage& frame = epoch.frame->frame;
  const auto trace = trace_of(frame, *epoch.ct_from_image, geometry);
  if (!trace) return;
  const auto image_from_ct = epoch.ct_from_image->inverse();
  const auto is_inside = [&](const Vec2& pixel) {
    if (!frame.outline) return true;
    return frame.outline->contains((image_from_ct * geometry.point_at(pixel)).mm.head<2>());
  };
  // One line from where the outline begins to where it ends.
  std::optional<Vec2> first, last;
  for (int i = 0; i <= kTraceSteps; ++i) {
    const Vec2 p = trace->first + (trace->second - trace->first) * i / kTraceSteps;
    const bool inside = is_inside(p);
    if (inside && !first) first = p;
    if (inside) last = p;
    if ((!inside || i == kTraceSteps) && first) {
      canvas.line(*first, *last, 4 * ratio, render::rgb8(0));
      canvas.line(*first, *last, 2 * ratio, colour_of(epoch.plane.state));
      first.reset();
    }
  }
}

}  // namespace

Point<frames::Ct> SliceGeometry::point_at(const Eigen::Vector2d& pixel) const {
  const Vec2 mm = mm_per_px * (pixel - Vec2(0.5 * (size.width - 1), 0.5 * (size.height - 1)));
  return {plane.centre_ct.mm + mm.x() * plane.right.v + mm.y() * plane.down.v};
}

Eigen::Vector3d SliceGeometry::pixel_of(const Point<frames::Ct>& point_ct) const {
  const Vec3 from_centre = point_ct.mm - plane.centre_ct.mm;
  return {from_centre.dot(plane.right.v) / mm_per_px + 0.5 * (size.width - 1),
          from_centre.dot(plane.down.v) / mm_per_px + 0.5 * (size.height - 1),
          from_centre.dot(plane.right.v.cross(plane.down.v))};
}

std::optional<SliceGeometry> slice_geometry(const PanelContext& context,
                                            const SliceRequest& request) {
  SliceGeometry geometry{.plane = {}, .mm_per_px = 1, .size = request.size};
  double width_mm = kNeedleExtentMm;
  double height_mm = kNeedleExtentMm;
  if (request.kind == SliceKind::kNeedleFirst || request.kind == SliceKind::kNeedleSecond) {
    if (!shows_needle(context.epoch)) return std::nullopt;
    const auto& ct_from_needle = *context.epoch.ct_from_needle;
    const double length_mm = std::max(context.needle_length_mm, 1.0);
    const auto planes =
        render::needle_slices(ct_from_needle * Point<frames::Needle>{{0, 0, -length_mm}},
                              ct_from_needle * Point<frames::Needle>{{0, 0, 0}});
    geometry.plane = planes[request.kind == SliceKind::kNeedleFirst ? 0 : 1];
  } else {
    const Eigen::AlignedBox3d box = box_of(context.ct.grid());
    const render::SlicePlane plane = orthogonal_plane(request.kind, request.cursor);
    const Vec3 across = plane.right.v.cross(plane.down.v);
    // The middle of the CT, at the depth of the cursor.
    const Vec3 centre = box.center();
    geometry.plane = plane;
    geometry.plane.centre_ct = {centre + across * across.dot(request.cursor.mm - centre)};
    width_mm = std::abs(box.sizes().dot(plane.right.v));
    height_mm = std::abs(box.sizes().dot(plane.down.v));
  }
  const double fitting = kSliceMargin * std::max(width_mm / std::max(1, request.size.width),
                                                 height_mm / std::max(1, request.size.height));
  geometry.mm_per_px = std::clamp(fitting / std::clamp(request.zoom.factor, 0.25, 64.0),
                                  kLeastMmPerPx, kMostMmPerPx);
  geometry.plane.centre_ct.mm += request.zoom.shift_mm.x() * geometry.plane.right.v +
                                 request.zoom.shift_mm.y() * geometry.plane.down.v;
  return geometry;
}

Point<frames::Ct> within_ct(const VoxelGrid& grid, const Point<frames::Ct>& point_ct) {
  Vec3 index = grid.index_of(point_ct);
  for (int axis = 0; axis < 3; ++axis) {
    const double last = grid.size[static_cast<std::size_t>(axis)] - 1;
    index[axis] = std::clamp(std::isfinite(index[axis]) ? index[axis] : 0, 0.0, last);
  }
  return {grid.at(index).mm};
}

Point<frames::Ct> stepped(const VoxelGrid& grid, SliceKind kind, const Point<frames::Ct>& point_ct,
                          double slices) {
  // LPS: superior is +z, anterior -y, the patient's right -x.
  const Vec3 way = kind == SliceKind::kAxial     ? Vec3(0, 0, 1)
                   : kind == SliceKind::kCoronal ? Vec3(0, -1, 0)
                                                 : Vec3(-1, 0, 0);
  int axis = 0;
  (grid.directions.transpose() * way).cwiseAbs().maxCoeff(&axis);
  return within_ct(grid, {point_ct.mm + slices * grid.spacing_mm[axis] * way});
}

render::HuWindow dragged_window(const render::HuWindow& window, const Eigen::Vector2d& drag) {
  constexpr double kLeastWidth = 1;
  constexpr double kMostWidth = 20000;
  constexpr double kFurthestLevel = 20000;
  const double width = std::clamp(window.width * std::exp(2 * std::clamp(drag.x(), -4.0, 4.0)),
                                  kLeastWidth, kMostWidth);
  // A drag over the whole height moves the level by the width of the window.
  const double level = std::clamp(window.level - window.width * std::clamp(drag.y(), -100.0, 100.0),
                                  -kFurthestLevel, kFurthestLevel);
  return {level, width};
}

std::optional<std::pair<Eigen::Vector2d, Eigen::Vector2d>> trace_of(
    const UltrasoundImage& frame, const Transform<frames::Ct, frames::Image>& ct_from_image,
    const SliceGeometry& geometry) {
  const auto [low, high] = box_mm(frame);
  const std::array<Vec2, 4> corners{low, Vec2(high.x(), low.y()), high, Vec2(low.x(), high.y())};
  // The slice cuts an edge of the image between two corners on different sides of it.
  std::array<Vec3, 4> at;
  for (std::size_t i = 0; i < 4; ++i) {
    at[i] = geometry.pixel_of(ct_from_image *
                              Point<frames::Image>{{corners[i].x(), corners[i].y(), 0}});
  }
  std::optional<Vec2> first;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3& a = at[i];
    const Vec3& b = at[(i + 1) % 4];
    if ((a.z() > 0) == (b.z() > 0)) continue;
    const Vec2 cut = (a + (b - a) * (a.z() / (a.z() - b.z()))).head<2>();
    if (first) return std::pair(*first, cut);
    first = cut;
  }
  return std::nullopt;
}

bool SliceDrawer::is_kept(const Key& key) const {
  if (!key_ || key_->ct.values().data() != key.ct.values().data()) return false;
  const SliceGeometry& a = key_->geometry;
  const SliceGeometry& b = key.geometry;
  return a.size == b.size && a.mm_per_px == b.mm_per_px &&
         a.plane.centre_ct.mm == b.plane.centre_ct.mm && a.plane.right.v == b.plane.right.v &&
         a.plane.down.v == b.plane.down.v && key_->window.level == key.window.level &&
         key_->window.width == key.window.width;
}

SliceDrawing SliceDrawer::draw(const PanelContext& context, const SliceRequest& request) {
  render::Canvas canvas(request.size.width, request.size.height, kSliceBackground);
  const auto geometry = slice_geometry(context, request);
  if (!geometry || is_small(request.size)) return {canvas.image(), std::nullopt};
  const Key key{context.ct, *geometry, context.window};
  if (!is_kept(key)) {
    const auto values = render::slice_values(context.ct, geometry->plane,
                                             {.width = request.size.width,
                                              .height = request.size.height,
                                              .mm_per_pixel = geometry->mm_per_px});
    NAV_CHECK(values.has_value(), request.size.width, request.size.height, geometry->mm_per_px);
    kept_ = render::to_grey(*values, context.window);
    key_ = key;
    ++sampled_;
  }
  canvas.copy(kept_, 0, 0);
  draw_trace(canvas, *geometry, context, request.ratio);
  if (context.plan) {
    draw_path_onto(canvas, view_of(*geometry), ct_from_slice(geometry->plane), *context.plan);
  }
  draw_in_plane(canvas, view_of(*geometry), ct_from_slice(geometry->plane), context);
  return {canvas.image(), geometry};
}

}  // namespace nav::app
