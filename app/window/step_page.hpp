// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QLabel>
#include <QWidget>
#include <map>

namespace nav::app {

/// The panel of a step: words of what is in use, and below them the step's controls if it has any.
class StepPage final : public QWidget {
 public:
  StepPage(QLabel* words, QWidget* parent);

  /// Adds the controls of a step, 0 to 6.
  void add(int step, QWidget* controls);
  void choose(int step);
  [[nodiscard]] bool has_controls(int step) const { return controls_.contains(step); }

 private:
  std::map<int, QWidget*> controls_;  ///< Controls of each step that has some.
};

}  // namespace nav::app
