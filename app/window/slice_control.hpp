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

/// Movement of the CT against the patient's image, as the user drags it by eye. In the CT's frame.
struct EyeMovement {
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();  ///< Axis times angle.
  Point<frames::Ct> about{Eigen::Vector3d::Zero()};    ///< Stays where it is when the CT turns.
};

/// Movement by a drag between two positions of a flat image, device pixels. What seems to move
/// follows the mouse: the CT in the ultrasound and along the plane, the plane in slices of the CT.
/// turns: about the middle of the view; otherwise a shift. Absent where the view has no point of
/// the CT.
std::optional<EyeMovement> eye_movement(ViewId id, const ViewImage& view_image,
                                        const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                        bool turns);

/// Point of the CT at a position of a flat image, device pixels; absent where there is none: the
/// view shows nothing, the image is not placed, or a bull's-eye.
std::optional<Point<frames::Ct>> ct_point_at(ViewId id, const ViewImage& view_image,
                                             const Eigen::Vector2d& at);

}  // namespace nav::app
