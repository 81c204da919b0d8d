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

/// Time of one image while only the user moves something, s.
constexpr double kBudget = 0.020;
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
  stopping_ = true;
  thread_.request_stop();
  orders_.close();
  if (thread_.joinable()) thread_.join();
}

void SceneEngine::draw(Order order) {
  orders_.put(order);
  compare(order);
}

void SceneEngine::look(Look look) {
  looks_.put(std::move(look));
  newer_ = render::SceneChange::kView;
}

render::SceneChange SceneEngine::newer() const {
  return stopping_ ? render::SceneChange::kView : newer_.load();
}

/// Finds how an order differs from what is being drawn.
void SceneEngine::compare(const Order& newer) {
  const std::lock_guard lock(drawing_mutex_);
  if (drawing_ != nullptr) newer_ = change_between(*drawing_, scene_of(newer));
}

void SceneEngine::begin_drawing(const render::Scene& scene) {
  {
    const std::lock_guard lock(drawing_mutex_);
    drawing_ = &scene;
    newer_ = render::SceneChange::kNothing;
  }
  // Orders that came before this are compared now.
  std::optional<Order> waiting;
  orders_.peek([&](const Order& order) { waiting = order; });
  if (waiting) compare(*waiting);
  looks_.peek([this](const Look&) { newer_ = render::SceneChange::kView; });
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
  // A graphics card needs no second one: it has memory and time enough.
  std::unique_ptr<render::Engine> second;
  std::optional<render::CoarseEngine> coarse;
  if ((*engine)->name() == "cpu") {
    auto made = make_engine("cpu", threads_, console_);
    if (!made) return hears_.failed(made.error().message);
    second = *std::move(made);
    coarse.emplace(render::CoarseEngine{*second});
  }
  render::CoarseEngine* const for_coarse = coarse ? &*coarse : nullptr;
  render::ProgressiveRenderer live(**engine, {.refine_after_s = kNeverRefine}, for_coarse);
  render::ProgressiveRenderer resting(**engine, {.budget_s = kBudget}, for_coarse);
  const auto renderer_of = [&](const Order& order) -> render::ProgressiveRenderer& {
    const Moment& moment = *order.moment;
    if (order.frozen || !moment.notice.empty() || !moment.acquired) return resting;
    const bool expected = clock_.now() - *moment.acquired < kExpectLive;
    return shows_live(moment.epoch) || expected ? live : resting;
  };
  render::ProgressiveRenderer* drew = nullptr;
  bool given_up = false;
  std::optional<Order> last;
  while (!stop.stop_requested()) {
    auto order = given_up ? orders_.take()
                          : orders_.wait(last ? Duration(kLookForOrders)
                                              : Duration(std::chrono::seconds(1)));
    if (const auto ns = hang_ns_.exchange(0); ns > 0) {
      std::this_thread::sleep_for(std::chrono::nanoseconds(ns));
    }
    look_now();
    const bool ordered = order.has_value();
    if (order) last = std::move(order);
    if (!last) continue;
    render::ProgressiveRenderer& renderer = renderer_of(*last);
    const bool rests = drew != &renderer || renderer.wants_refinement(clock_.now());
    if (!ordered && !rests && !given_up) continue;
    drew = &renderer;
    live_budget_.ordered(last->moment->number, last->moment->published);
    live.set_budget(live_budget_.budget_s());
    auto view_image = draw_now(*last, renderer);
    given_up = !view_image && view_image.error().code == ErrorCode::kCancelled;
    if (given_up) {
      ++interrupted_;
      continue;
    }
    if (!view_image) return hears_.failed(view_image.error().message);
    hears_.done(*std::move(view_image));
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

Result<ViewImage> SceneEngine::draw_now(const Order& order, render::ProgressiveRenderer& renderer) {
  const render::Scene scene = scene_of(order);
  const auto start = std::chrono::steady_clock::now();
  begin_drawing(scene);
  auto drawn = renderer.draw_small(scene, clock_.now(), [this] { return newer(); });
  {
    const std::lock_guard lock(drawing_mutex_);
    drawing_ = nullptr;
  }
  if (!drawn) return drawn.error();
  const double draw_ms = 1e3 * seconds_since(start);
  const auto converting = std::chrono::steady_clock::now();
  ViewImage view_image{.moment = order.moment,
                       .image = to_rgb32(drawn->image.pixels, order.size),
                       .camera = scene.camera,
                       .refined = drawn->refined,
                       .factor = drawn->factor,
                       .asked = order.number};
  draw_heartbeat(view_image.image, ++beat_);
  view_image.draw_ms = draw_ms;
  view_image.convert_ms = 1e3 * seconds_since(converting);
  live_budget_.drawn(drawn->image.statistics.cast_s, seconds_since(start));
  return view_image;
}

}  // namespace nav::app
