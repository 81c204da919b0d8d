// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QEvent>
#include <QKeyEvent>
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
    return window_.press(*static_cast<QKeyEvent*>(event));
  }

 private:
  MainWindow& window_;
};

}  // namespace nav::app
