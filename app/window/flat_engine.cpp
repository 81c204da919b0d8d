// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/flat_engine.hpp"

#include <chrono>
#include <exception>

#include "app/views/bulls_eye.hpp"
#include "app/views/flat_views.hpp"
#include "nav/stopwatch.hpp"

namespace nav::app {
namespace {

/// Draws one view after the other. One thread.
class FlatDrawer {
 public:
  [[nodiscard]] FlatImages draw(const FlatEngine::Order& order) {
    PanelContext context = context_of(*order.moment);
    if (order.settings.window) context.window = *order.settings.window;
    const SlicedVolume sliced = sliced_volume(order.settings, *order.moment);
    FlatImages view_images;
    view_images.moment = order.moment;
    ++beat_;
    for (const ViewId id : kFlatViews) {
      if (order.sizes[id].width > 0) {
        view_images.views[id] = draw(id, order, context, sliced);
      }
    }
    return view_images;
  }

 private:
  ViewImage draw(ViewId id, const FlatEngine::Order& order, const PanelContext& of_ct,
                 const SlicedVolume& sliced) {
    const bool of_ultrasound = is_orthogonal(id) && sliced.is_ultrasound;
    const PanelContext of_sliced{.epoch = of_ct.epoch,
                                 .ct = *sliced.volume,
                                 .plan = of_ct.plan,
                                 .window = sliced.window,
                                 .banner = of_ct.banner,
                                 .needle_expected = of_ct.needle_expected,
                                 .needle_length_mm = of_ct.needle_length_mm};
    const PanelContext& context = of_ultrasound ? of_sliced : of_ct;
    ViewImage view_image{.moment = order.moment,
                         .cursor = cursor_of(order.settings, *order.moment),
                         .window = context.window,
                         .asked = order.number};
    view_image.of_ultrasound = of_ultrasound;
    const auto start = std::chrono::steady_clock::now();
    Image2d<Rgba8> image;
    const PixelSize size = order.sizes[id];
    if (const auto kind = slice_of(id)) {
      SliceDrawing drawing = slices_[id].draw(context, {.kind = *kind,
                                                        .size = size,
                                                        .ratio = order.ratio,
                                                        .cursor = view_image.cursor,
                                                        .zoom = order.settings.zoom[id]});
      image = std::move(drawing.image);
      view_image.slice = drawing.geometry;
    } else if (id == ViewId::kBullsEye) {
      SliceDrawing drawing = draw_bulls_eye(context, size, order.ratio);
      image = std::move(drawing.image);
      view_image.slice = drawing.geometry;
    } else {
      FlatView view = id == ViewId::kCt
                          ? draw_ct_view(context, size)
                          : draw_ultrasound_view(context, size, order.settings.overlay);
      image = std::move(view.image);
      view_image.plane = view.plane;
    }
    view_image.draw_ms = 1e3 * seconds_since(start);
    const auto converting = std::chrono::steady_clock::now();
    view_image.image = to_rgb32(image);
    draw_heartbeat(view_image.image, beat_);
    view_image.convert_ms = 1e3 * seconds_since(converting);
    return view_image;
  }

  PerView<SliceDrawer> slices_;
  std::uint64_t beat_ = 0;
};

}  // namespace

SlicedVolume sliced_volume(const SliceSettings& settings, const Moment& moment) {
  if (!moment.predicates || !(settings.of_ultrasound || moment.stored)) {
    return {moment.ct, settings.window.value_or(moment.window)};
  }
  const render::PredicateVolume& volume = moment.predicates->volume;
  const auto& intensity = volume.predicates.intensity;
  const render::HuWindow window{0.5 * (intensity.black + intensity.white),
                                intensity.white - intensity.black};
  return {volume.ultrasound, settings.ultrasound_window.value_or(window), true};
}

Point<frames::Ct> cursor_of(const SliceSettings& settings, const Moment& moment) {
  const VoxelGrid& grid = settings.of_ultrasound && moment.predicates
                              ? moment.predicates->volume.ultrasound->grid()
                              : moment.ct->grid();
  if (settings.cursor) return within_ct(grid, *settings.cursor);
  if (moment.plan) return within_ct(grid, moment.plan->target_ct);
  return grid.centre();
}

void FlatEngine::start() {
  thread_ = std::jthread([this](const std::stop_token& stop) {
    try {
      run(stop);
    } catch (const std::exception& failure) {
      hears_.failed(std::string("the flat views failed: ") + failure.what());
    }
  });
}

void FlatEngine::stop() {
  thread_.request_stop();
  orders_.close();
  if (thread_.joinable()) thread_.join();
}

void FlatEngine::run(const std::stop_token& stop) {
  FlatDrawer drawer;
  while (!stop.stop_requested()) {
    auto order = orders_.wait(std::chrono::seconds(1));
    if (!order) continue;
    if (const auto ns = hang_ns_.exchange(0); ns > 0) {
      std::this_thread::sleep_for(std::chrono::nanoseconds(ns));
    }
    hears_.done(drawer.draw(*order));
  }
}

}  // namespace nav::app
