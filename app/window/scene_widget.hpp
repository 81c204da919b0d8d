// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/window/view_widget.hpp"
#include "render/camera_movement.hpp"

namespace nav::app {

/// The 3D view: turned by the left button, moved by the middle one, zoomed by the right one and the
/// wheel. Letters of the patient's directions at its edges.
class SceneWidget final : public ViewWidget {
 public:
  using ViewWidget::ViewWidget;

  /// Called for every movement of the camera.
  std::function<void(const render::CameraMovement&)> moved;

 protected:
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;

 private:
  void paint_marks(QPainter& painter, const Picture& picture) override;

  QPointF last_;
  Qt::MouseButton button_ = Qt::NoButton;  ///< The one that began the drag; others do nothing.
};

}  // namespace nav::app
