// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "app/console.hpp"
#include "app/window/live_budget.hpp"
#include "app/window/mailbox.hpp"
#include "app/window/scene_edits.hpp"
#include "app/window/view_image.hpp"
#include "render/quality/progressive.hpp"

namespace nav::app {

/// Name of an engine, or "auto": OpenGL on a graphics card, otherwise the CPU engine.
Result<std::unique_ptr<render::Engine>> engine_for_window(const std::string& name, int threads,
                                                          Diagnostics& diagnostics);

/// Draws the 3D view on a thread of its own; it takes the newest order only. While something moves,
/// images are as coarse as they have to be to come in time; once everything rests, the image is
/// drawn in full, unless a newer order shows something else meanwhile. An image of live ultrasound
/// takes what remains of the time to the next one; while the camera rests, rays that plane and
/// needle do not affect stay, so that there is time for more pixels.
class SceneEngine {
 public:
  struct Order {
    SharedMoment moment{};
    std::optional<render::Camera> camera{};  ///< Absent: the session's.
    PixelSize size{1, 1};                    ///< Device pixels.
    std::uint64_t number = 0;                ///< Number of the newest camera order.
    bool frozen = false;                     ///< Nothing newer will be wanted for now.
    /// Cursor of the slices, once the user has set it.
    std::optional<Point<frames::Ct>> cursor{};
    /// Changes of the user; null: none.
    std::shared_ptr<const SceneEdits> edits{};
  };
  /// A pixel of the image that an order made.
  struct Look {
    Order order{};
    int x = 0, y = 0;
  };
  struct Hears {
    std::function<void(ViewImage)> done;  ///< Called on the engine's thread, as is failed.
    std::function<void(std::string)> failed;
    /// The point that the pixel of a look() shows; absent: nothing can be seen there.
    std::function<void(std::optional<Point<frames::Ct>>)> looked = nullptr;
  };
  /// The clock and the console must outlive it. \p name: of engine_for_window().
  SceneEngine(std::string name, int threads, const Clock& clock, Console& console, Hears hears);
  ~SceneEngine() { stop(); }

  void start();
  /// Joins the thread. Idempotent.
  void stop();
  /// An image in full that is being drawn is given up if this order shows something else.
  void draw(Order order);
  /// Finds the point that a pixel shows, and tells \c looked. An image in full is given up for it.
  void look(Look look);
  [[nodiscard]] std::uint64_t superseded() const { return orders_.superseded(); }
  /// Number of images that were given up for newer orders. Thread-safe.
  [[nodiscard]] std::uint64_t interrupted() const { return interrupted_; }
  /// For tests: does not draw for a time, as an engine that hangs.
  void hang(Duration time) { hang_ns_ = time.count(); }
  /// Name and device of the engine; empty before it is there. Thread-safe.
  [[nodiscard]] std::pair<std::string, std::string> engine() const;

 private:
  void run(const std::stop_token& stop);
  [[nodiscard]] static render::Scene scene_of(const Order& order);
  void look_now();
  void compare(const Order& newer);
  void begin_drawing(const render::Scene& scene);
  [[nodiscard]] render::SceneChange newer() const;
  Result<ViewImage> draw_now(const Order& order, render::ProgressiveRenderer& renderer);

  std::string name_;
  int threads_;
  const Clock& clock_;
  Console& console_;
  Hears hears_;
  Mailbox<Order> orders_;
  Mailbox<Look> looks_;
  std::atomic<Duration::rep> hang_ns_{0};
  std::uint64_t beat_ = 0;
  LiveBudget live_budget_;
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint64_t> interrupted_{0};
  /// The change from the scene that is drawn to the order that waits.
  std::atomic<render::SceneChange> newer_{render::SceneChange::kNothing};
  std::mutex drawing_mutex_;
  const render::Scene* drawing_ = nullptr;  ///< Guarded by drawing_mutex_; null: none.
  mutable std::mutex mutex_;
  std::pair<std::string, std::string> engine_;  ///< Guarded by the mutex.
  std::jthread thread_;
};

}  // namespace nav::app
