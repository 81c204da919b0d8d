// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QWidget>
#include <functional>

#include "app/window/small_controls.hpp"

namespace nav::app {

/// Controls of the step Review: the file of the session.
class SessionPage final : public QWidget {
 public:
  explicit SessionPage(QWidget* parent);

  /// The file in the field.
  [[nodiscard]] QString path() const { return path_->text(); }
  void set_path(const QString& path) { path_->setText(path); }
  /// A sentence about the last order; asks: a file would be replaced, which takes the user's word.
  void say(const QString& words, bool asks);
  [[nodiscard]] bool asks() const { return !replace_->isHidden(); }
  [[nodiscard]] QString words() const { return words_->text(); }

  std::function<void()> save, replace;

 private:
  QLineEdit* path_;
  QPushButton *save_, *replace_, *keep_;
  QLabel* words_;
};

/// A sentence above the views about what another window left, with the two answers.
class RecoveryBar final : public QWidget {
 public:
  explicit RecoveryBar(QWidget* parent);

  /// Empty words hide it.
  void say(const QString& words);
  [[nodiscard]] QString words() const { return words_->text(); }
  std::function<void()> restore, discard;

 private:
  void paintEvent(QPaintEvent* event) override;

  QLabel* words_;
};

}  // namespace nav::app
