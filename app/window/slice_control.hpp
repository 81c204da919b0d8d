// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "app/window/flat_engine.hpp"

namespace nav::app {

/// An input of the user to a flat view. Positions are device pixels of its image.
struct SliceInput {
  enum class Kind {
    kCursor,  ///< The cursor goes to \c at.
    kStep,    ///< The cursor goes \c amount slices across the view.
    kZoom,    ///< Enlarges by the factor \c amount; the point at \c at keeps its position.
    kPan,     ///< The image follows a drag by \c drag pixels.
    kWindow   ///< Window and level follow a drag by \c drag, as a share of the view's height.
  };
  Kind kind;
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  Eigen::Vector2d drag = Eigen::Vector2d::Zero();
  double amount = 0;
};

/// Keeps the cursor, the grey window, zooms and shifts of the slices. Window's thread.
class SliceControl {
 public:
  /// Applies an input to a view whose image the user sees. False: it does nothing there.
  bool apply(ViewId id, const SliceInput& input, const ViewImage& seen);
  /// Cursor, windows, zooms and shifts as at the beginning.
  void reset();
  /// Cursor, windows, zooms and shifts as they were saved.
  void restore(const SliceSettings& settings);

  /// The orthogonal slices show the 3D ultrasound, or the CT.
  void show_ultrasound(bool shown);

  /// The CT over the ultrasound.
  void set_overlay(const CtOverlay& overlay);

  [[nodiscard]] const SliceSettings& settings() const { return settings_; }
  /// Counts the changes.
  [[nodiscard]] std::uint64_t number() const { return number_; }

 private:
  bool change(ViewId id, const SliceInput& input, const ViewImage& seen);
  void zoom(ViewId id, double factor, const Eigen::Vector2d& at, const SliceGeometry& geometry);

  SliceSettings settings_;
  std::uint64_t number_ = 0;
};

/// Point of the CT at a position of a flat image, device pixels; absent where there is none: the
/// view shows nothing, the image is not placed, or a bull's-eye.
std::optional<Point<frames::Ct>> ct_point_at(ViewId id, const ViewImage& view_image,
                                             const Eigen::Vector2d& at);

}  // namespace nav::app
