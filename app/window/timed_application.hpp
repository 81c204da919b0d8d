// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QApplication>
#include <QEvent>
#include <chrono>

#include "app/window/window_report.hpp"
#include "nav/stopwatch.hpp"

namespace nav::app {

/// An application that measures how long its thread is busy with each event.
class TimedApplication final : public QApplication {
 public:
  TimedApplication(int& argc, char** argv) : QApplication(argc, argv) {}

  /// Null: nothing is measured. It must outlive the application.
  void measure_into(WindowReport* report) { report_ = report; }

  bool notify(QObject* receiver, QEvent* event) override {
    if (depth_ > 0 || report_ == nullptr) return QApplication::notify(receiver, event);
    const QEvent::Type type = event->type();  // The event may be gone afterwards.
    const auto start = std::chrono::steady_clock::now();
    ++depth_;
    const bool handled = QApplication::notify(receiver, event);
    --depth_;
    const double ms = 1e3 * seconds_since(start);
    const bool paints = type == QEvent::UpdateRequest || type == QEvent::Paint;
    if (!paints) report_->handler(ms);
    report_->block(ms);
    return handled;
  }

 private:
  WindowReport* report_ = nullptr;
  int depth_ = 0;
};

}  // namespace nav::app
