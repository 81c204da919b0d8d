// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QPointF>
#include <QSize>
#include <functional>
#include <optional>

#include "app/window/view_id.hpp"
#include "app/window/view_image.hpp"

class QPainter;

namespace nav::app {

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

/// Movement by a drag in the 3D view: the ultrasound plane follows the mouse. It is shifted
/// parallel to the screen, by its distance from the eye, or turns about the line of sight through
/// the middle of the view. Absent where no plane is drawn.
std::optional<EyeMovement> eye_movement_3d(const ViewImage& view_image, const Eigen::Vector2d& from,
                                           const Eigen::Vector2d& to, bool turns);

/// A dashed ring in the middle of a view by which the left button places the CT by eye: a drag from
/// inside of it shifts, from outside turns. Window's thread.
class EyeHandles {
 public:
  enum class Drag { kNone, kShift, kTurn };

  /// Called for the movements of a drag, and at its ends.
  std::function<void(const EyeMovement&)> moved;
  std::function<void(bool begins)> dragged;

  /// Ends a drag that is under way. False: nothing changes.
  bool set_on(bool on);
  [[nodiscard]] bool on() const { return on_; }
  /// Begins a drag at a position in a view of that size, logical pixels.
  void begin(const QPointF& at, const QSize& size);
  /// False: no drag was under way.
  bool end();
  [[nodiscard]] Drag drag() const { return drag_; }
  /// Ring, arrows and what they do; also: more words, may be empty.
  static void paint(QPainter& painter, const QSize& size, const QString& also);

 private:
  bool on_ = false;
  Drag drag_ = Drag::kNone;
};

}  // namespace nav::app
