// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/theme.hpp"

#include <QGuiApplication>
#include <QPainterPath>
#include <algorithm>
#include <array>
#include <cmath>

#include "app/console.hpp"

namespace nav::app::theme {

QColor colour_of_state(SafetyState state) {
  switch (state) {
    case SafetyState::kValid:
      return QColor(0x2f, 0xd0, 0x60);
    case SafetyState::kDegraded:
      return QColor(0xff, 0xb4, 0x00);
    case SafetyState::kStale:
    case SafetyState::kLost:
      return QColor(0xa8, 0xae, 0xb4);
  }
  return QColor(0xa8, 0xae, 0xb4);
}

void draw_state_shape(QPainter& painter, const QRectF& square, SafetyState state) {
  painter.save();
  painter.setRenderHint(QPainter::Antialiasing);
  const QColor colour = colour_of_state(state);
  painter.setPen(Qt::NoPen);
  painter.setBrush(colour);
  if (state == SafetyState::kValid) {
    painter.drawEllipse(square);
  } else if (state == SafetyState::kDegraded) {
    const std::array<QPointF, 3> corners{QPointF(square.center().x(), square.top()),
                                         square.bottomRight(), square.bottomLeft()};
    painter.drawPolygon(corners.data(), 3);
  } else if (state == SafetyState::kStale) {
    const double third = square.height() / 3;
    painter.drawRect(square.adjusted(0, third, 0, -third));
  } else {
    painter.setPen(QPen(colour, square.width() / 4));
    painter.drawLine(square.topLeft(), square.bottomRight());
    painter.drawLine(square.topRight(), square.bottomLeft());
  }
  painter.restore();
}

double text_scale() {
  const int pixels = QGuiApplication::font().pixelSize();
  return pixels > 0 ? static_cast<double>(pixels) / kTextPixels : 1;
}

void set_text_scale(double scale) {
  QFont font = QGuiApplication::font();
  font.setPixelSize(static_cast<int>(std::lround(kTextPixels * std::clamp(scale, 1.0, 2.0))));
  QGuiApplication::setFont(font);
}

int scaled(int pixels) { return static_cast<int>(std::lround(pixels * text_scale())); }

QFont fitting_font(const QString& line, int pixels, double width, bool bold, bool* fits) {
  constexpr int kLeastPixels = 9;
  QFont made = font(pixels, bold);
  const auto is_wide = [&] { return QFontMetricsF(made).horizontalAdvance(line) > width; };
  while (made.pixelSize() > kLeastPixels && is_wide()) made.setPixelSize(made.pixelSize() - 1);
  if (fits != nullptr && is_wide()) *fits = false;
  return made;
}

QFont font(int pixels, bool bold) {
  QFont made(QStringLiteral("DejaVu Sans"));
  made.setPixelSize(scaled(pixels));
  made.setBold(bold);
  return made;
}

double draw_tag(QPainter& painter, double x, double y, const QString& text, const QFont& font,
                const QColor& colour) {
  if (text.isEmpty()) return x;
  painter.setFont(font);
  const QFontMetricsF metrics(font);
  const double width = metrics.horizontalAdvance(text);
  const QRectF box(x, y, width + 12, metrics.height() + 4);
  painter.fillRect(box, QColor(0x10, 0x14, 0x18, 0xd8));
  painter.setPen(colour);
  painter.drawText(QPointF(x + 6, y + 2 + metrics.ascent()), text);
  return box.right();
}

QString plain(const std::string& text) { return QString::fromStdString(without_controls(text)); }

QString style_sheet() {
  return QStringLiteral(
             "QWidget { color: #e6ebf0; font-family: 'DejaVu Sans'; font-size: %1px; }"
             "QPushButton { background: #26303a; border: 2px solid #36424d; border-radius: 6px;"
             " padding: 4px 10px; text-align: left; min-height: 44px; }"
             "QPushButton:hover { background: #2f3b47; }"
             "QPushButton:checked { background: #1f5f8c; border-color: #8fd3ff; }"
             "QPushButton:focus { border-color: #ffffff; }"
             "QPushButton:disabled { color: #a7b2bc; }"
             "QPushButton[small=\"true\"] { min-height: 20px; padding: 2px 6px; text-align: center;"
             " border-radius: 4px; }"
             "QComboBox, QDoubleSpinBox, QLineEdit { background: #26303a; border: 2px solid "
             "#36424d;"
             " border-radius: 4px; padding: 1px 4px; min-height: 22px; }"
             "QComboBox:focus, QDoubleSpinBox:focus, QLineEdit:focus { border-color: #ffffff; }"
             "QComboBox:disabled, QDoubleSpinBox:disabled { color: #a7b2bc; }"
             "QComboBox QAbstractItemView { background: #26303a; selection-background-color: "
             "#1f5f8c; }"
             "QSlider::groove:vertical { background: #36424d; width: 6px; border-radius: 3px; }"
             "QSlider::groove:horizontal { background: #36424d; height: 6px; border-radius: 3px; }"
             "QSlider::handle:vertical { background: #8fd3ff; height: 14px; margin: 0 -8px;"
             " border-radius: 4px; }"
             "QSlider::handle:horizontal { background: #8fd3ff; width: 14px; margin: -8px 0;"
             " border-radius: 4px; }"
             "QSlider::handle:focus, QSlider::handle:hover { background: #ffffff; }"
             "QSlider::handle:disabled { background: #5a6670; }"
             "QCheckBox { spacing: 6px; min-height: 28px; }"
             "QCheckBox::indicator { width: 18px; height: 18px; border: 2px solid #8795a2;"
             " border-radius: 3px; background: #26303a; }"
             "QCheckBox::indicator:checked { background: #8fd3ff; }"
             "QCheckBox:focus { color: #ffffff; }"
             "QScrollArea, QScrollArea > QWidget > QWidget { background: #1b2229; }"
             "QScrollArea#rail-scroll, QScrollArea#rail-scroll > QWidget > QWidget {"
             " background: #101418; }"
             "QScrollBar:vertical { background: #1b2229; width: 12px; }"
             "QScrollBar::handle:vertical { background: #5a6670; min-height: 28px; border-radius: "
             "4px; }"
             "QScrollBar::add-line, QScrollBar::sub-line { height: 0; }"
             "QToolTip { background: #1b2229; color: #e6ebf0; border: 1px solid #36424d; }"
             "QLabel#panel { background: #1b2229; }"
             "QLabel#keys { background: #1b2229; border: 2px solid #8fd3ff; }")
      .arg(scaled(kTextPixels));
}

}  // namespace nav::app::theme
