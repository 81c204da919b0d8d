// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QPushButton>
#include <vector>

#include "app/window/eye_handles.hpp"
#include "app/window/view_widget.hpp"
#include "render/camera_movement.hpp"

namespace nav::app {

/// The 3D view: turned by the left button, moved by the middle one, zoomed by the right one and the
/// wheel; a double click looks at a point. Buttons of the sides of the patient. Letters of the
/// patient's directions at its edges.
class SceneWidget final : public ViewWidget {
 public:
  SceneWidget(const QString& name, const QString& title, QWidget* parent);

  /// Called for a double click, with the image that the user sees and a pixel of it.
  std::function<void(const ViewImage&, int x, int y)> looked_at;
  /// Called by the buttons of the sides of the patient.
  std::function<void(render::ViewFrom)> seen_from;
  /// Called for every movement of the camera.
  std::function<void(const render::CameraMovement&)> moved;

  /// Shows the handles, or not. While they are shown, Ctrl and the left button turn the view.
  void set_by_eye(bool on);
  EyeHandles& handles() { return handles_; }

  /// Puts the buttons of the sides where they have space, in the size of their texts.
  void place_sides();

 protected:
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void mouseDoubleClickEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;

 private:
  void paint_marks(QPainter& painter, const ViewImage& view_image) override;
  /// Asks for the point that a position of the view shows.
  void look(const QPointF& position);

  /// True: the left button places the CT.
  [[nodiscard]] bool places() const;
  /// Places the CT by a drag between two positions.
  void place(const QPointF& from, const QPointF& to);

  EyeHandles handles_;
  std::vector<QPushButton*> sides_;
  QPointF last_;
  Qt::MouseButton button_ = Qt::NoButton;  ///< The one that began the drag; others do nothing.
};

}  // namespace nav::app
