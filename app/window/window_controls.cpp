// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/window_controls.hpp"

#include <QAbstractScrollArea>
#include <QCheckBox>
#include <algorithm>
#include <cmath>
#include <sstream>

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

/// True: a line of the text is wider than the control has place for, or its lines are higher.
bool is_clipped(const QPushButton& button) {
  const int frame = button.property("small").toBool() ? 2 * (6 + 2) : 2 * (10 + 2);
  const QFontMetrics metrics(button.font());
  const auto lines = button.text().split(QLatin1Char('\n'));
  const int widest = metrics.size(0, button.text()).width();
  return widest + frame > button.width() ||
         static_cast<int>(lines.size()) * metrics.height() > button.height();
}

/// True: the control is cut at the left or right by what it lies in, or leaves the window.
/// Upwards and downwards panels scroll.
bool is_outside(const QWidget& control, const QWidget& window) {
  bool scrolls = false;
  for (const QWidget* parent = control.parentWidget(); parent != nullptr;
       parent = parent->parentWidget()) {
    const QRect at(control.mapTo(parent, QPoint(0, 0)), control.size());
    if (at.left() < 0 || at.right() >= parent->width()) return true;
    scrolls |= qobject_cast<const QAbstractScrollArea*>(parent->parentWidget()) != nullptr;
    if (!scrolls && (at.top() < 0 || at.bottom() >= parent->height())) return true;
    if (parent == &window) break;
  }
  return false;
}

/// True: a text of the control is shortened, because it has no place for all of it.
bool is_elided(const QWidget& control) {
  const auto* choice = qobject_cast<const QComboBox*>(&control);
  if (choice == nullptr) return false;
  constexpr int kArrowAndFrame = 28;
  return choice->fontMetrics().horizontalAdvance(choice->currentText()) + kArrowAndFrame >
         choice->width();
}

bool cuts_text(const QWidget& control) {
  if (const auto* button = qobject_cast<const QPushButton*>(&control)) return is_clipped(*button);
  if (const auto* numerals = dynamic_cast<const Numerals*>(&control)) return numerals->clipped();
  if (const auto* lines = dynamic_cast<const StatusLines*>(&control)) return lines->clipped();
  if (const auto* number = qobject_cast<const QDoubleSpinBox*>(&control)) {
    constexpr int kFrame = 2 * (4 + 2);
    return number->fontMetrics().horizontalAdvance(number->text()) + kFrame > number->width();
  }
  if (const auto* box = qobject_cast<const QCheckBox*>(&control)) {
    return box->sizeHint().width() > box->width();
  }
  const auto* label = qobject_cast<const QLabel*>(&control);
  if (label == nullptr) return false;
  if (label->wordWrap()) return label->heightForWidth(label->width()) > label->height();
  return label->sizeHint().width() > label->width() || label->sizeHint().height() > label->height();
}

/// Accessible name of what the control lies in; empty: the window itself.
std::string part_of(const QWidget& control, const QWidget& window) {
  for (const QWidget* parent = control.parentWidget(); parent != nullptr && parent != &window;
       parent = parent->parentWidget()) {
    const bool scrolls = qobject_cast<const QAbstractScrollArea*>(parent) != nullptr;
    if (!scrolls && !parent->accessibleName().isEmpty()) {
      return parent->accessibleName().toStdString();
    }
  }
  return {};
}

const char* kind_of(const QWidget& control) {
  if (qobject_cast<const QAbstractButton*>(&control) != nullptr) return "button";
  if (qobject_cast<const QComboBox*>(&control) != nullptr) return "choice";
  if (qobject_cast<const QAbstractSpinBox*>(&control) != nullptr) return "number";
  if (qobject_cast<const QLineEdit*>(&control) != nullptr) return "field";
  if (qobject_cast<const QAbstractSlider*>(&control) != nullptr) return "slider";
  if (qobject_cast<const QLabel*>(&control) != nullptr) return "text";
  if (dynamic_cast<const ViewWidget*>(&control) != nullptr) return "view";
  return "panel";
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
    const bool clipped = control->isVisible() && !control->isWindow() &&
                         (cuts_text(*control) || is_outside(*control, window));
    all.push_back({{"name", name.toStdString()},
                   {"kind", kind_of(*control)},
                   {"part", part_of(*control, window)},
                   {"accessible_name", control->accessibleName().toStdString()},
                   {"shortcut", key.empty() ? io::Json(nullptr) : io::Json(key)},
                   {"width_px", control->width()},
                   {"height_px", control->height()},
                   {"elided", control->isVisible() && is_elided(*control)},
                   {"clipped", clipped},
                   {"contrast", contrast_of(theme::kWindowText, theme::kWindowPanel)}});
  }
  return all;
}

Result<std::string> with_controls(const std::string& page, const io::Json& controls) {
  std::string text;
  bool begun = false;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    text += line + "\n";
    if (line != "<!-- controls -->") continue;
    begun = true;
    while (std::getline(lines, line) && line != "<!-- end -->") {
    }
    if (line != "<!-- end -->") {
      return Error{ErrorCode::kMalformedData,
                   "expected <!-- end --> after <!-- controls -->, found the end of the page"};
    }
    text += "\n| control | kind | in | is | key |\n|---|---|---|---|---|\n";
    for (const io::Json& one : controls) {
      const auto name = one["name"].get<std::string>();
      if (name.ends_with("-scroll") || name.ends_with("-label")) continue;
      text += "| `" + name + "` | " + one["kind"].get<std::string>() + " | " +
              one["part"].get<std::string>() + " | " + one["accessible_name"].get<std::string>() +
              " | " + (one["shortcut"].is_null() ? "" : one["shortcut"].get<std::string>()) +
              " |\n";
    }
    text += "\n" + line + "\n";
  }
  if (begun) return text;
  return Error{ErrorCode::kMalformedData, "expected the line <!-- controls -->, found none"};
}

void lengthen_texts(QWidget& window) {
  const auto longer = [](const QString& text) {
    QStringList lines = text.split(QLatin1Char('\n'));
    for (QString& line : lines) {
      // Repeats the beginning of the line: words of the same kind, which can wrap.
      const auto more = static_cast<qsizetype>(std::ceil(0.4 * static_cast<double>(line.size())));
      line += line.left(more);
    }
    return lines.join(QLatin1Char('\n'));
  };
  for (auto* button : window.findChildren<QAbstractButton*>()) {
    if (!button->text().isEmpty()) button->setText(longer(button->text()));
  }
  for (auto* label : window.findChildren<QLabel*>()) {
    if (label->textFormat() != Qt::RichText) label->setText(longer(label->text()));
  }
}

}  // namespace nav::app
