// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/scene_widget.hpp"

#include <QMouseEvent>
#include <QPainter>
#include <algorithm>
#include <cmath>

#include "app/window/theme.hpp"

namespace nav::app {

void SceneWidget::mousePressEvent(QMouseEvent* event) {
  if (button_ != Qt::NoButton) return;
  button_ = event->button();
  last_ = event->position();
}

void SceneWidget::mouseReleaseEvent(QMouseEvent* event) {
  if (event->button() == button_) button_ = Qt::NoButton;
}

void SceneWidget::mouseMoveEvent(QMouseEvent* event) {
  if (button_ == Qt::NoButton || !moved) return;
  const QPointF way = (event->position() - last_) / std::max(1, height());
  last_ = event->position();
  const Eigen::Vector2d drag(way.x(), -way.y());
  render::CameraMovement movement;
  if (button_ == Qt::LeftButton) {
    movement.orbit = drag;
  } else if (button_ == Qt::MiddleButton) {
    movement.pan = drag;
  } else {
    movement.zoom = std::exp(2 * std::clamp(drag.y(), -2.0, 2.0));
  }
  moved(movement);
}

void SceneWidget::wheelEvent(QWheelEvent* event) {
  constexpr double kWheelZoom = 1.1;
  constexpr double kNotch = 120;
  render::CameraMovement movement;
  movement.zoom = std::pow(kWheelZoom, std::clamp(event->angleDelta().y() / kNotch, -20.0, 20.0));
  if (moved) moved(movement);
  event->accept();
}

void SceneWidget::paint_marks(QPainter& painter, const Picture& picture) {
  const ViewLetters letters = view_letters(picture.camera);
  const QFont font = theme::font(18, true);
  const QFontMetricsF metrics(font);
  const auto letter = [&](double x, double y, const std::string& words) {
    const QString text = theme::plain(words);
    theme::draw_tag(painter, x - metrics.horizontalAdvance(text) / 2 - 6,
                    y - metrics.height() / 2 - 2, text, font, QColor::fromRgb(theme::kWindowText));
  };
  letter(24, height() / 2.0, letters.left);
  letter(width() - 24, height() / 2.0, letters.right);
  letter(width() / 2.0, 22, letters.up);
  letter(width() / 2.0, height() - 22, letters.down);
}

}  // namespace nav::app
