// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QWidget>
#include <functional>

#include "app/window/small_controls.hpp"

namespace nav::app {

/// Controls of the step Patient: another CT is opened in the background.
class PatientPage final : public QWidget {
 public:
  explicit PatientPage(QWidget* parent);

  [[nodiscard]] QString path() const { return path_->text(); }
  void set_path(const QString& path) { path_->setText(path); }
  void say(const QString& words) { words_->setText(words); }
  /// A CT is being read: Cancel can be pressed.
  void set_busy(bool busy);

  std::function<void()> open, cancel;

 private:
  void browse(bool folder);

  QLineEdit* path_;
  QPushButton *open_, *file_, *folder_, *cancel_;
  QLabel* words_;
};

}  // namespace nav::app
