// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "app/window/mailbox.hpp"
#include "app/window/picture.hpp"

namespace nav::app {

/// The two flat views of one moment.
struct FlatPictures {
  Picture ultrasound, ct;
};

/// Sizes of the flat views, device pixels.
struct FlatSizes {
  PixelSize ultrasound{1, 1}, ct{1, 1};
};

/// Draws the flat views on a thread of its own; it takes the newest moment only.
class FlatEngine {
 public:
  struct Order {
    SharedMoment moment;
    FlatSizes sizes;
  };
  struct Hears {
    std::function<void(FlatPictures)> done;  ///< Called on the engine's thread, as is failed.
    std::function<void(std::string)> failed;
  };
  explicit FlatEngine(Hears hears) : hears_(std::move(hears)) {}
  ~FlatEngine() { stop(); }

  void start();
  /// Joins the thread. Idempotent.
  void stop();
  void draw(Order order) { orders_.put(std::move(order)); }
  [[nodiscard]] std::uint64_t superseded() const { return orders_.superseded(); }
  /// For tests: does not draw for a time.
  void hang(Duration time) { hang_ns_ = time.count(); }

 private:
  void run(const std::stop_token& stop);

  Hears hears_;
  Mailbox<Order> orders_;
  std::atomic<Duration::rep> hang_ns_{0};
  std::jthread thread_;
};

}  // namespace nav::app
