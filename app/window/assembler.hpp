// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>

#include "app/window/flat_engine.hpp"
#include "app/window/view_image.hpp"
#include "nav/time.hpp"

namespace nav::app {

/// Images that a refresh puts on the screen; parts that do not change are absent.
struct Assembled {
  std::optional<FlatImages> flat;
  std::optional<ViewImage> scene;
};

/// Decides which images are shown together: those of one moment. The flat views wait for the 3D
/// view of their moment, but not for long: after kMostWait they go on, and the 3D view is late
/// until it shows their moment again. One thread; times are arguments.
class RefreshAssembler {
 public:
  static constexpr Duration kMostWait = std::chrono::milliseconds(60);

  void add(FlatImages flat, Timestamp now);
  void add(ViewImage scene, Timestamp now);
  /// False: the 3D view is not on the screen; the flat views do not wait for it.
  void expect_scene(bool expected);
  /// Returns the images to be shown now; none: what is on the screen stays.
  Assembled next(Timestamp now);

  /// Numbers of the moments on the screen; 0: none yet.
  [[nodiscard]] std::uint64_t flat_number() const { return flat_number_; }
  [[nodiscard]] std::uint64_t scene_number() const { return scene_number_; }
  /// The 3D view shows an older moment than the flat views, and has to say so.
  [[nodiscard]] bool scene_is_late() const { return with_scene_ && scene_number_ != flat_number_; }
  /// Images that a newer one replaced before they were shown.
  [[nodiscard]] std::uint64_t superseded() const { return superseded_; }

 private:
  struct Waiting {
    FlatImages flat;
    Timestamp since;
  };
  FlatImages take_flat(std::size_t index);

  std::deque<Waiting> flats_;
  std::optional<ViewImage> scene_;
  bool with_scene_ = true;
  Timestamp scene_since_{};
  std::uint64_t flat_number_ = 0;
  std::uint64_t scene_number_ = 0;
  std::uint64_t superseded_ = 0;
};

}  // namespace nav::app
