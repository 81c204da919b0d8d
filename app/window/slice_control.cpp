// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/slice_control.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace nav::app {
namespace {

constexpr double kLeastZoom = 0.25;
constexpr double kMostZoom = 64;
/// A slice cannot be shifted out of sight.
constexpr double kFurthestShiftMm = 2000;

}  // namespace

std::optional<Point<frames::Ct>> ct_point_at(ViewId id, const ViewImage& view_image,
                                             const Eigen::Vector2d& at) {
  if (slice_of(id)) {
    if (!view_image.slice) return std::nullopt;
    return view_image.slice->point_at(at);
  }
  const bool flat = id == ViewId::kCt || id == ViewId::kUltrasound;
  if (!flat || !view_image.plane || !view_image.moment) return std::nullopt;
  const session::Epoch& epoch = view_image.moment->epoch;
  if (!epoch.ct_from_image || epoch.plane.state > SafetyState::kDegraded) return std::nullopt;
  const PlaneView& plane = *view_image.plane;
  const Eigen::Vector2d mm =
      plane.origin_mm + plane.mm_per_px * (at - Eigen::Vector2d(plane.x, plane.y));
  return *epoch.ct_from_image * Point<frames::Image>{{mm.x(), mm.y(), 0}};
}

bool SliceControl::apply(ViewId id, const SliceInput& input, const ViewImage& seen) {
  if (!seen.moment || !seen.moment->ct || !change(id, input, seen)) return false;
  ++number_;
  return true;
}

void SliceControl::reset() {
  const SliceSettings before = settings_;
  settings_ = {};
  settings_.of_ultrasound = before.of_ultrasound;
  settings_.overlay = before.overlay;
  ++number_;
}

void SliceControl::restore(const SliceSettings& settings) {
  const SliceSettings before = settings_;
  settings_ = settings;
  settings_.of_ultrasound = before.of_ultrasound;
  settings_.overlay = before.overlay;
  ++number_;
}

void SliceControl::set_overlay(const CtOverlay& overlay) {
  settings_.overlay = overlay;
  ++number_;
}

void SliceControl::show_ultrasound(bool shown) {
  if (settings_.of_ultrasound == shown) return;
  settings_.of_ultrasound = shown;
  ++number_;
}

bool SliceControl::change(ViewId id, const SliceInput& input, const ViewImage& seen) {
  const SlicedVolume sliced = sliced_volume(settings_, *seen.moment);
  const VoxelGrid& grid = sliced.volume->grid();
  switch (input.kind) {
    case SliceInput::Kind::kCursor: {
      const auto point = ct_point_at(id, seen, input.at);
      if (!point) return false;
      settings_.cursor = within_ct(grid, *point);
      return true;
    }
    case SliceInput::Kind::kStep:
      if (!is_orthogonal(id)) return false;
      // From the newest cursor: several notches come between two images.
      settings_.cursor =
          stepped(grid, *slice_of(id), cursor_of(settings_, *seen.moment), input.amount);
      return true;
    case SliceInput::Kind::kWindow:
      if (id == ViewId::kUltrasound || id == ViewId::kBullsEye) return false;
      if (is_orthogonal(id) && sliced.is_ultrasound) {
        settings_.ultrasound_window = dragged_window(sliced.window, input.drag);
        return true;
      }
      settings_.window = dragged_window(settings_.window.value_or(seen.moment->window), input.drag);
      return true;
    case SliceInput::Kind::kZoom:
      if (!slice_of(id) || !seen.slice) return false;
      zoom(id, input.amount, input.at, *seen.slice);
      return true;
    case SliceInput::Kind::kPan:
      if (!slice_of(id) || !seen.slice) return false;
      settings_.zoom[id].shift_mm =
          (settings_.zoom[id].shift_mm - seen.slice->mm_per_px * input.drag)
              .cwiseMax(-kFurthestShiftMm)
              .cwiseMin(kFurthestShiftMm);
      return true;
  }
  return false;
}

void SliceControl::zoom(ViewId id, double factor, const Eigen::Vector2d& at,
                        const SliceGeometry& geometry) {
  SliceZoom& zoom = settings_.zoom[id];
  const double before = zoom.factor;
  zoom.factor = std::clamp(before * std::clamp(factor, 1e-3, 1e3), kLeastZoom, kMostZoom);
  // The distance of the point from the middle shrinks with the scale, so the middle moves to it.
  const Eigen::Vector2d middle(0.5 * (geometry.size.width - 1), 0.5 * (geometry.size.height - 1));
  const double now_mm_per_px = geometry.mm_per_px * before / zoom.factor;
  zoom.shift_mm = (zoom.shift_mm + (geometry.mm_per_px - now_mm_per_px) * (at - middle))
                      .cwiseMax(-kFurthestShiftMm)
                      .cwiseMin(kFurthestShiftMm);
}

}  // namespace nav::app
