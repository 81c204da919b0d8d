// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QAbstractSpinBox>
#include <QEvent>
#include <QKeyEvent>
#include <QLineEdit>
#include <QObject>

#include "app/window/main_window.hpp"

namespace nav::app {

/// Gives the keys of actions to the window, whichever control has the focus: Space freezes, even on
/// a button.
class KeyFilter final : public QObject {
 public:
  /// The window must outlive it.
  explicit KeyFilter(MainWindow& window) : window_(window) {}

  bool eventFilter(QObject* watched, QEvent* event) override {
    if (event->type() != QEvent::KeyPress || !watched->isWidgetType()) return false;
    const auto& key = *static_cast<QKeyEvent*>(event);
    return !types(*watched, key) && window_.press(key);
  }

 private:
  /// True: the key edits a number or a text, and is none of the window's.
  static bool types(const QObject& watched, const QKeyEvent& key) {
    const bool number = qobject_cast<const QAbstractSpinBox*>(watched.parent()) != nullptr;
    if (qobject_cast<const QLineEdit*>(&watched) != nullptr && !number) {
      // Letters and the keys of a text field; Ctrl+S, F1 and Esc stay the window's.
      const bool edits = key.matches(QKeySequence::Copy) || key.matches(QKeySequence::Paste) ||
                         key.matches(QKeySequence::Cut) || key.matches(QKeySequence::SelectAll);
      const bool plain = !(key.modifiers() & (Qt::ControlModifier | Qt::AltModifier));
      return edits || (plain && key.key() != Qt::Key_Escape &&
                       !(key.key() >= Qt::Key_F1 && key.key() <= Qt::Key_F35));
    }
    const auto is_field = [](const QObject* object) {
      return qobject_cast<const QAbstractSpinBox*>(object) != nullptr;
    };
    if (!is_field(&watched) && !is_field(watched.parent())) return false;
    if (key.modifiers() & ~(Qt::ShiftModifier | Qt::KeypadModifier)) return false;
    const QString text = key.text();
    return !text.isEmpty() && QStringLiteral("0123456789.,-+eE").contains(text.front());
  }

  MainWindow& window_;
};

}  // namespace nav::app
