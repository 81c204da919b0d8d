// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/scene_engine.hpp"

#include <chrono>
#include <exception>

#include "app/engines.hpp"
#include "nav/stopwatch.hpp"
#include "render/visible_point.hpp"

namespace nav::app {
namespace {

/// Time of one image while ultrasound is live, s.
constexpr double kLiveBudget = 0.020;
/// Time without a change after which a live image would be drawn in full: never.
constexpr double kNeverRefine = 1e9;
constexpr auto kLookForOrders = std::chrono::milliseconds(20);

/// Time for which a session that goes on is expected to deliver again. Meanwhile the engine does
/// not begin a long image.
constexpr Duration kExpectLive = std::chrono::seconds(2);

bool shows_live(const session::Epoch& epoch) {
  return epoch.plane.state <= SafetyState::kDegraded ||
         (epoch.ct_from_needle && epoch.needle.state <= SafetyState::kDegraded);
}

/// Three thin lines through the cursor, along the patient's axes.
void add_cursor(render::Scene& scene, const Point<frames::Ct>& cursor) {
  constexpr double kArmMm = 12;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d arm = kArmMm * Eigen::Vector3d::Unit(axis);
    scene.lines.push_back({.from_ct = {cursor.mm - arm},
                           .to_ct = {cursor.mm + arm},
                           .radius_mm = 0.4,
                           .rgb = {1, 1, 1}});
  }
}

bool is_software(const std::string& device) {
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "Software"}) {
    if (device.find(name) != std::string::npos) return true;
  }
  return false;
}

}  // namespace

Result<std::unique_ptr<render::Engine>> engine_for_window(const std::string& name, int threads,
                                                          Diagnostics& diagnostics) {
  if (name != "auto") return make_engine(name, threads, diagnostics);
  auto gl = make_engine("gl", threads, diagnostics);
  if (gl && !is_software((*gl)->device())) return gl;
  return make_engine("cpu", threads, diagnostics);
}

SceneEngine::SceneEngine(std::string name, int threads, const Clock& clock, Console& console,
                         Hears hears)
    : name_(std::move(name)),
      threads_(threads),
      clock_(clock),
      console_(console),
      hears_(std::move(hears)) {}

void SceneEngine::start() {
  thread_ = std::jthread([this](const std::stop_token& stop) {
    try {
      run(stop);
    } catch (const std::exception& failure) {
      hears_.failed(std::string("the engine failed: ") + failure.what());
    }
  });
}

void SceneEngine::stop() {
  thread_.request_stop();
  orders_.close();
  if (thread_.joinable()) thread_.join();
}

std::pair<std::string, std::string> SceneEngine::engine() const {
  const std::lock_guard lock(mutex_);
  return engine_;
}

void SceneEngine::run(const std::stop_token& stop) {
  auto engine = engine_for_window(name_, threads_, console_);
  if (!engine) return hears_.failed(engine.error().message);
  {
    const std::lock_guard lock(mutex_);
    engine_ = {(*engine)->name(), (*engine)->device()};
  }
  render::ProgressiveRenderer live(**engine,
                                   {.budget_s = kLiveBudget, .refine_after_s = kNeverRefine});
  render::ProgressiveRenderer resting(**engine, {.budget_s = kLiveBudget});
  const auto renderer_of = [&](const Order& order) -> render::ProgressiveRenderer& {
    const Moment& moment = *order.moment;
    if (order.frozen || !moment.notice.empty() || !moment.acquired) return resting;
    const bool expected = clock_.now() - *moment.acquired < kExpectLive;
    return shows_live(moment.epoch) || expected ? live : resting;
  };
  render::ProgressiveRenderer* drew = nullptr;
  std::optional<Order> last;
  while (!stop.stop_requested()) {
    auto order = orders_.wait(last ? Duration(kLookForOrders) : Duration(std::chrono::seconds(1)));
    if (const auto ns = hang_ns_.exchange(0); ns > 0) {
      std::this_thread::sleep_for(std::chrono::nanoseconds(ns));
    }
    look_now();
    const bool ordered = order.has_value();
    if (order) last = std::move(order);
    if (!last) continue;
    render::ProgressiveRenderer& renderer = renderer_of(*last);
    const bool rests = drew != &renderer || renderer.wants_refinement(clock_.now());
    if (!ordered && !rests) continue;
    drew = &renderer;
    auto picture = draw_now(*last, renderer);
    if (!picture) return hears_.failed(picture.error().message);
    hears_.done(*std::move(picture));
  }
}

render::Scene SceneEngine::scene_of(const Order& order) {
  render::Scene scene = *order.moment->scene;
  if (order.camera) scene.camera = *order.camera;
  if (order.edits) apply_edits_to(*order.edits, scene);
  scene.width = order.size.width;
  scene.height = order.size.height;
  if (order.cursor) add_cursor(scene, *order.cursor);
  return scene;
}

void SceneEngine::look_now() {
  const auto look = looks_.take();
  if (!look || !hears_.looked) return;
  const auto point = render::visible_point(scene_of(look->order), look->x, look->y);
  hears_.looked(point ? *point : std::nullopt);
}

Result<Picture> SceneEngine::draw_now(const Order& order, render::ProgressiveRenderer& renderer) {
  const render::Scene scene = scene_of(order);
  const auto start = std::chrono::steady_clock::now();
  auto drawn = renderer.draw(scene, clock_.now());
  if (!drawn) return drawn.error();
  const double draw_ms = 1e3 * seconds_since(start);
  const auto converting = std::chrono::steady_clock::now();
  Picture picture{.moment = order.moment,
                  .image = to_rgb32(drawn->image.pixels),
                  .camera = scene.camera,
                  .refined = drawn->refined,
                  .asked = order.number};
  draw_heartbeat(picture.image, ++beat_);
  picture.draw_ms = draw_ms;
  picture.convert_ms = 1e3 * seconds_since(converting);
  return picture;
}

}  // namespace nav::app
