// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/scene_widget.hpp"

#include <QMouseEvent>
#include <QPainter>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "app/window/small_controls.hpp"
#include "app/window/theme.hpp"

namespace nav::app {
namespace {

constexpr int kSideButton = 30;

}  // namespace

SceneWidget::SceneWidget(const QString& name, const QString& title, QWidget* parent)
    : ViewWidget(name, title, parent) {
  struct Side {
    const char* name;
    const char* letter;
    const char* accessible;
    render::ViewFrom from;
  };
  constexpr std::array<Side, 6> kSides{
      {{"view-anterior", "A", "View from anterior", render::ViewFrom::kAnterior},
       {"view-posterior", "P", "View from posterior", render::ViewFrom::kPosterior},
       {"view-left", "L", "View from the patient's left", render::ViewFrom::kLeft},
       {"view-right", "R", "View from the patient's right", render::ViewFrom::kRight},
       {"view-head", "H", "View from the head", render::ViewFrom::kHead},
       {"view-feet", "F", "View from the feet", render::ViewFrom::kFeet}}};
  for (const Side& side : kSides) {
    auto* button = small_button(QLatin1String(side.name), QLatin1String(side.letter),
                                QLatin1String(side.accessible), this);
    QObject::connect(button, &QPushButton::clicked, this, [this, from = side.from] {
      if (seen_from) seen_from(from);
    });
    sides_.push_back(button);
  }
}

/// At the lower left, beside the letter in the middle of the edge: one row, two where the view is
/// narrow, none in a view without space.
void SceneWidget::place_sides() {
  constexpr int kGap = 4;
  constexpr int kLeastHeight = 200;
  constexpr int kEdge = 8;
  constexpr int kLetter = 40;
  int side = theme::scaled(kSideButton);
  for (const QPushButton* button : sides_) side = std::max(side, button->sizeHint().width());
  const int pitch = side + kGap;
  const int space = width() / 2 - kLetter;
  const auto count = static_cast<int>(sides_.size());
  const int columns = space > count * pitch ? count : (count + 1) / 2;
  const int rows = (count + columns - 1) / columns;
  const bool fits = space > columns * pitch && height() >= kLeastHeight;
  for (int i = 0; i < count; ++i) {
    QPushButton* button = sides_[static_cast<std::size_t>(i)];
    button->setVisible(fits);
    button->setGeometry(kEdge + i % columns * pitch,
                        height() - kEdge + kGap - (rows - i / columns) * pitch, side, side);
  }
}

void SceneWidget::resizeEvent(QResizeEvent* event) {
  place_sides();
  ViewWidget::resizeEvent(event);
}

void SceneWidget::mouseDoubleClickEvent(QMouseEvent* event) {
  if (event->button() == Qt::LeftButton) look(event->position());
}

void SceneWidget::look(const QPointF& position) {
  if (!looked_at || !view_image() || judgement().covered) return;
  const QImage& image = view_image()->image;
  const QPointF at = position * image.devicePixelRatio();
  looked_at(*view_image(), static_cast<int>(std::floor(at.x())),
            static_cast<int>(std::floor(at.y())));
}

void SceneWidget::mousePressEvent(QMouseEvent* event) {
  if (button_ != Qt::NoButton) return;
  if (event->button() == Qt::LeftButton && has_mode()) return look(event->position());
  button_ = event->button();
  last_ = event->position();
  const bool turns_view = event->modifiers().testFlag(Qt::ControlModifier);
  if (button_ == Qt::LeftButton && places() && !turns_view) handles_.begin(last_, size());
}

void SceneWidget::mouseReleaseEvent(QMouseEvent* event) {
  if (event->button() != button_) return;
  button_ = Qt::NoButton;
  handles_.end();
}

void SceneWidget::set_by_eye(bool on) {
  if (handles_.set_on(on)) update();
}

bool SceneWidget::places() const {
  return handles_.on() && view_image() && !judgement().covered &&
         eye_movement_3d(*view_image(), {0, 0}, {0, 0}, false).has_value();
}

void SceneWidget::place(const QPointF& from, const QPointF& to) {
  if (!places() || !handles_.moved) return;
  const double ratio = devicePixelRatioF();
  const auto pixel = [&](const QPointF& at) -> Eigen::Vector2d {
    return {ratio * at.x() - 0.5, ratio * at.y() - 0.5};
  };
  const auto movement = eye_movement_3d(*view_image(), pixel(from), pixel(to),
                                        handles_.drag() == EyeHandles::Drag::kTurn);
  if (movement) handles_.moved(*movement);
}

void SceneWidget::mouseMoveEvent(QMouseEvent* event) {
  if (button_ == Qt::NoButton || !moved) return;
  if (handles_.drag() != EyeHandles::Drag::kNone) {
    return place(std::exchange(last_, event->position()), event->position());
  }
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

void SceneWidget::paint_marks(QPainter& painter, const ViewImage& view_image) {
  if (places()) EyeHandles::paint(painter, size(), QStringLiteral("Ctrl turns the view"));
  const ViewLetters letters = view_letters(view_image.camera);
  const QFont font = theme::font(18, true);
  const QFontMetricsF metrics(font);
  const auto letter = [&](double x, double y, const std::string& words) {
    const QString text = theme::plain(words);
    theme::draw_tag(painter, x - metrics.horizontalAdvance(text) / 2 - 6,
                    y - metrics.height() / 2 - 2, text, font, QColor::fromRgb(theme::kWindowText));
  };
  letter(24, height() / 2.0, letters.left);
  letter(width() - 24, height() / 2.0, letters.right);
  // Below the line of title and state where they meet it.
  constexpr int kNarrow = 520;
  letter(width() / 2.0, width() < kNarrow ? 54 : 22, letters.up);
  letter(width() / 2.0, height() - 22, letters.down);
}

}  // namespace nav::app
