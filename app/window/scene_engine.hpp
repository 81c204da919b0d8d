// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "app/console.hpp"
#include "app/window/mailbox.hpp"
#include "app/window/picture.hpp"
#include "app/window/scene_edits.hpp"
#include "render/quality/progressive.hpp"

namespace nav::app {

/// Name of an engine, or "auto": OpenGL on a graphics card, otherwise the CPU engine.
Result<std::unique_ptr<render::Engine>> engine_for_window(const std::string& name, int threads,
                                                          Diagnostics& diagnostics);

/// Draws the 3D view on a thread of its own; it takes the newest order only. While something moves,
/// images are as coarse as they have to be to come in time; once everything rests, the image is
/// drawn in full. An image of live ultrasound is never drawn in full if that would make it old.
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
    std::function<void(Picture)> done;  ///< Called on the engine's thread, as is failed.
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
  void draw(Order order) { orders_.put(std::move(order)); }
  /// Finds the point that a pixel shows, and tells \c looked.
  void look(Look look) { looks_.put(std::move(look)); }
  [[nodiscard]] std::uint64_t superseded() const { return orders_.superseded(); }
  /// For tests: does not draw for a time, as an engine that hangs.
  void hang(Duration time) { hang_ns_ = time.count(); }
  /// Name and device of the engine; empty before it is there. Thread-safe.
  [[nodiscard]] std::pair<std::string, std::string> engine() const;

 private:
  void run(const std::stop_token& stop);
  [[nodiscard]] static render::Scene scene_of(const Order& order);
  void look_now();
  Result<Picture> draw_now(const Order& order, render::ProgressiveRenderer& renderer);

  std::string name_;
  int threads_;
  const Clock& clock_;
  Console& console_;
  Hears hears_;
  Mailbox<Order> orders_;
  Mailbox<Look> looks_;
  std::atomic<Duration::rep> hang_ns_{0};
  std::uint64_t beat_ = 0;
  mutable std::mutex mutex_;
  std::pair<std::string, std::string> engine_;  ///< Guarded by the mutex.
  std::jthread thread_;
};

}  // namespace nav::app
