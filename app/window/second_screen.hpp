// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QTimer>
#include <QWidget>
#include <functional>
#include <vector>

namespace nav::app {

/// A second window for another screen, without controls. It paints what views and numbers of the
/// main window show now, with their states, covers and withdrawn numbers, and has no image of its
/// own that could grow old. Window's thread.
class SecondScreen final : public QWidget {
 public:
  /// A widget of the main window, which may be hidden there, and where it is painted, in any units.
  struct Mirrored {
    QWidget* widget;
    QRect at;
  };
  /// shown: gives the widgets to mirror, children of main, which must outlive it.
  SecondScreen(QWidget* main, std::function<std::vector<Mirrored>()> shown);
  /// Called when it has another size, was opened or closed.
  std::function<void()> changed;

  /// Opens it on another screen if there is one, in full; otherwise as a window beside.
  void open();

 private:
  void paintEvent(QPaintEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  void showEvent(QShowEvent* event) override;
  void hideEvent(QHideEvent* event) override;

  std::function<std::vector<Mirrored>()> shown_;
  QTimer timer_;
};

}  // namespace nav::app
