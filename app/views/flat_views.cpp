// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/flat_views.hpp"

#include <cmath>

#include "app/views/plane_overlays.hpp"

namespace nav::app {
namespace {

constexpr Rgba8 kViewBackground = render::rgb8(0x101418);

/// Nothing can be seen in a smaller view, and its pixels would be too large for a slice.
constexpr int kLeastViewPixels = 16;

bool is_too_small(PixelSize size) {
  return size.width < kLeastViewPixels || size.height < kLeastViewPixels;
}

/// Weight of the CT at a pixel of the view.
double ct_weight(const CtOverlay& overlay, const PlaneView& view, int x, int y) {
  constexpr double kSquareMm = 10;
  switch (overlay.mode) {
    case CtOverlay::Mode::kNone:
      return 0;
    case CtOverlay::Mode::kBlend:
      return overlay.share;
    case CtOverlay::Mode::kWipe:
      return x < overlay.share * view.width ? 1 : 0;
    case CtOverlay::Mode::kCheckerboard: {
      const Eigen::Vector2d square = (view.point_of(x, y) / kSquareMm).array().floor();
      return std::fmod(std::abs(square.sum()), 2) < 0.5 ? 1 : 0;
    }
  }
  return 0;
}

/// The CT laid over the image of a view; both have the size of the view.
Image2d<Rgba8> laid_over(const Image2d<Rgba8>& ct, const PlaneView& view, const CtOverlay& overlay,
                         const Image2d<Rgba8>& image) {
  std::vector<Rgba8> mixed;
  mixed.reserve(image.pixels().size());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double weight = ct_weight(overlay, view, x, y);
      const Rgba8& over = ct.at(x, y);
      const Rgba8& under = image.at(x, y);
      const auto mix = [&](std::uint8_t a, std::uint8_t b) {
        return static_cast<std::uint8_t>(std::lround(weight * a + (1 - weight) * b));
      };
      mixed.push_back({mix(over.r, under.r), mix(over.g, under.g), mix(over.b, under.b), under.a});
    }
  }
  return {image.width(), image.height(), std::move(mixed)};
}

}  // namespace

FlatView draw_ultrasound_view(const PanelContext& context, PixelSize size,
                              const CtOverlay& overlay) {
  const session::Epoch& epoch = context.epoch;
  render::Canvas canvas(size.width, size.height, kViewBackground);
  if (is_too_small(size) || !epoch.frame || epoch.ultrasound.state > SafetyState::kDegraded) {
    return {canvas.image(), std::nullopt};
  }
  const PlaneView view = fit(epoch.frame->frame, 0, 0, size.width, size.height);
  draw_ultrasound(canvas, view, epoch.frame->frame);
  const bool placed = epoch.ct_from_image && epoch.plane.state <= SafetyState::kDegraded;
  if (placed && overlay.mode != CtOverlay::Mode::kNone) {
    const auto ct =
        render::slice_along_image(context.ct, *epoch.ct_from_image, view.origin_mm, view.mm_per_px,
                                  view.width, view.height, context.window);
    canvas.copy(laid_over(ct, view, overlay, canvas.image()), 0, 0);
  }
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
