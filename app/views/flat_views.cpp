// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/flat_views.hpp"

#include "app/views/plane_overlays.hpp"

namespace nav::app {
namespace {

constexpr Rgba8 kViewBackground = render::rgb8(0x101418);

/// Nothing can be seen in a smaller view, and its pixels would be too large for a slice.
constexpr int kLeastViewPixels = 16;

bool is_too_small(PixelSize size) {
  return size.width < kLeastViewPixels || size.height < kLeastViewPixels;
}

}  // namespace

FlatView draw_ultrasound_view(const PanelContext& context, PixelSize size) {
  const session::Epoch& epoch = context.epoch;
  render::Canvas canvas(size.width, size.height, kViewBackground);
  if (is_too_small(size) || !epoch.frame || epoch.ultrasound.state > SafetyState::kDegraded) {
    return {canvas.image(), std::nullopt};
  }
  const PlaneView view = fit(epoch.frame->frame, 0, 0, size.width, size.height);
  draw_ultrasound(canvas, view, epoch.frame->frame);
  if (epoch.placement.state == SafetyState::kValid) draw_in_plane(canvas, view, context);
  return {canvas.image(), view};
}

FlatView draw_ct_view(const PanelContext& context, PixelSize size) {
  const session::Epoch& epoch = context.epoch;
  render::Canvas canvas(size.width, size.height, kViewBackground);
  if (is_too_small(size) || !epoch.frame || !epoch.ct_from_image ||
      epoch.plane.state > SafetyState::kDegraded) {
    return {canvas.image(), std::nullopt};
  }
  const PlaneView view = fit(epoch.frame->frame, 0, 0, size.width, size.height);
  canvas.copy(render::slice_along_image(context.ct, *epoch.ct_from_image, view.origin_mm,
                                        view.mm_per_px, view.width, view.height, context.window),
              0, 0);
  draw_in_plane(canvas, view, context);
  return {canvas.image(), view};
}

}  // namespace nav::app
