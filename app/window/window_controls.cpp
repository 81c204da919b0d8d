// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/window_controls.hpp"

#include <QAbstractButton>
#include <algorithm>
#include <cmath>

#include "app/window/theme.hpp"

namespace nav::app {
namespace {

double luminance(QRgb colour) {
  const auto linear = [](int byte) {
    const double c = byte / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(qRed(colour)) + 0.7152 * linear(qGreen(colour)) +
         0.0722 * linear(qBlue(colour));
}

/// True: a line of the text is wider than the control has place for.
bool is_clipped(const QAbstractButton& button) {
  const int frame = button.property("small").toBool() ? 2 * (6 + 2) : 2 * (10 + 2);
  const QFontMetrics metrics(button.font());
  const auto lines = button.text().split(QLatin1Char('\n'));
  const int widest = metrics.size(0, button.text()).width();
  return widest + frame > button.width() ||
         static_cast<int>(lines.size()) * metrics.height() > button.height();
}

}  // namespace

double contrast_of(QRgb a, QRgb b) {
  const double first = luminance(a) + 0.05;
  const double second = luminance(b) + 0.05;
  return std::max(first, second) / std::min(first, second);
}

io::Json controls_of(const MainWindow& window) {
  io::Json all = io::Json::array();
  for (const QWidget* control : window.findChildren<QWidget*>()) {
    const QString name = control->objectName();
    if (name.isEmpty() || name.startsWith(QLatin1String("qt_"))) continue;
    std::string key;
    for (const Action& action : window.actions().all()) {
      if (action.name == name) key = action.key.toString().toStdString();
    }
    const auto* button = qobject_cast<const QAbstractButton*>(control);
    const auto* label = qobject_cast<const QLabel*>(control);
    const bool clipped = button != nullptr
                             ? button->isVisible() && is_clipped(*button)
                             : label != nullptr && label->isVisible() &&
                                   label->heightForWidth(label->width()) > label->height();
    all.push_back({{"name", name.toStdString()},
                   {"kind", button != nullptr  ? "button"
                            : label != nullptr ? "text"
                                               : "view"},
                   {"accessible_name", control->accessibleName().toStdString()},
                   {"shortcut", key.empty() ? io::Json(nullptr) : io::Json(key)},
                   {"width_px", control->width()},
                   {"height_px", control->height()},
                   {"elided", false},
                   {"clipped", clipped},
                   {"contrast", contrast_of(theme::kWindowText, theme::kWindowPanel)}});
  }
  return all;
}

}  // namespace nav::app
