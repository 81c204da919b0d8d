// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/flat_engine.hpp"

#include <chrono>
#include <exception>

#include "app/views/flat_views.hpp"
#include "nav/stopwatch.hpp"

namespace nav::app {
namespace {

Picture flat_picture(const SharedMoment& moment, const FlatView& view, double draw_ms,
                     std::uint64_t beat) {
  const auto start = std::chrono::steady_clock::now();
  Picture picture{.moment = moment, .image = to_rgb32(view.image), .plane = view.plane};
  draw_heartbeat(picture.image, beat);
  picture.draw_ms = draw_ms;
  picture.convert_ms = 1e3 * seconds_since(start);
  return picture;
}

}  // namespace

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
  std::uint64_t beat = 0;
  while (!stop.stop_requested()) {
    auto order = orders_.wait(std::chrono::seconds(1));
    if (!order) continue;
    if (const auto ns = hang_ns_.exchange(0); ns > 0) {
      std::this_thread::sleep_for(std::chrono::nanoseconds(ns));
    }
    const PanelContext context = context_of(*order->moment);
    ++beat;
    auto start = std::chrono::steady_clock::now();
    const FlatView ultrasound = draw_ultrasound_view(context, order->sizes.ultrasound);
    const double ultrasound_ms = 1e3 * seconds_since(start);
    start = std::chrono::steady_clock::now();
    const FlatView ct = draw_ct_view(context, order->sizes.ct);
    const double ct_ms = 1e3 * seconds_since(start);
    hears_.done({flat_picture(order->moment, ultrasound, ultrasound_ms, beat),
                 flat_picture(order->moment, ct, ct_ms, beat)});
  }
}

}  // namespace nav::app
