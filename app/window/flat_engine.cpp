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
  [[nodiscard]] FlatPictures draw(const FlatEngine::Order& order) {
    PanelContext context = context_of(*order.moment);
    if (order.settings.window) context.window = *order.settings.window;
    FlatPictures pictures;
    pictures.moment = order.moment;
    ++beat_;
    for (const ViewId id : kFlatViews) {
      if (order.sizes[id].width > 0) pictures.views[id] = draw(id, order, context);
    }
    return pictures;
  }

 private:
  Picture draw(ViewId id, const FlatEngine::Order& order, const PanelContext& context) {
    Picture picture{.moment = order.moment,
                    .cursor = cursor_of(order.settings, *order.moment),
                    .window = context.window,
                    .asked = order.number};
    const auto start = std::chrono::steady_clock::now();
    Image2d<Rgba8> image;
    const PixelSize size = order.sizes[id];
    if (const auto kind = slice_of(id)) {
      SliceDrawing drawing = slices_[id].draw(context, {.kind = *kind,
                                                        .size = size,
                                                        .ratio = order.ratio,
                                                        .cursor = picture.cursor,
                                                        .zoom = order.settings.zoom[id]});
      image = std::move(drawing.image);
      picture.slice = drawing.geometry;
    } else if (id == ViewId::kBullsEye) {
      SliceDrawing drawing = draw_bulls_eye(context, size, order.ratio);
      image = std::move(drawing.image);
      picture.slice = drawing.geometry;
    } else {
      FlatView view =
          id == ViewId::kCt ? draw_ct_view(context, size) : draw_ultrasound_view(context, size);
      image = std::move(view.image);
      picture.plane = view.plane;
    }
    picture.draw_ms = 1e3 * seconds_since(start);
    const auto converting = std::chrono::steady_clock::now();
    picture.image = to_rgb32(image);
    draw_heartbeat(picture.image, beat_);
    picture.convert_ms = 1e3 * seconds_since(converting);
    return picture;
  }

  PerView<SliceDrawer> slices_;
  std::uint64_t beat_ = 0;
};

}  // namespace

Point<frames::Ct> cursor_of(const SliceSettings& settings, const Moment& moment) {
  if (settings.cursor) return within_ct(moment.ct->grid(), *settings.cursor);
  if (moment.plan) return within_ct(moment.ct->grid(), moment.plan->target_ct);
  return moment.ct->grid().centre();
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
