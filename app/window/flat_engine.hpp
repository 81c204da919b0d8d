// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "app/views/flat_views.hpp"
#include "app/window/mailbox.hpp"
#include "app/window/view_id.hpp"
#include "app/window/view_image.hpp"

namespace nav::app {

/// The flat views of one moment; views that were not ordered are absent.
struct FlatImages {
  SharedMoment moment{};
  PerView<std::optional<ViewImage>> views{};
};

/// Settings of the user for the slices, the same for all views of a refresh.
struct SliceSettings {
  std::optional<Point<frames::Ct>> cursor{};  ///< Absent: the target, else the middle of the CT.
  std::optional<render::HuWindow> window{};   ///< Absent: the session's.
  PerView<SliceZoom> zoom{};
  /// The orthogonal slices show the 3D ultrasound in place of the CT, where the moment has one.
  bool of_ultrasound = false;
  CtOverlay overlay{};                                  ///< Over the ultrasound.
  std::optional<render::HuWindow> ultrasound_window{};  ///< Absent: black and white of its values.
};

/// The volume that the orthogonal slices show.
struct SlicedVolume {
  std::shared_ptr<const StoredVolume> volume;
  render::HuWindow window;     ///< Grey window, in the volume's values.
  bool is_ultrasound = false;  ///< Stored values of 3D ultrasound, not HU.
};
SlicedVolume sliced_volume(const SliceSettings& settings, const Moment& moment);

/// The cursor of the slices of a moment.
Point<frames::Ct> cursor_of(const SliceSettings& settings, const Moment& moment);

/// Draws the flat views on a thread of its own; it takes the newest order only.
class FlatEngine {
 public:
  struct Order {
    SharedMoment moment{};
    PerView<PixelSize> sizes{};  ///< Device pixels; 0 x 0: the view is not on the screen.
    double ratio = 1;            ///< Device pixels of a pixel of the screen.
    SliceSettings settings{};
    std::uint64_t number = 0;  ///< Number of the newest change of the settings.
  };
  struct Hears {
    std::function<void(FlatImages)> done;  ///< Called on the engine's thread, as is failed.
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
