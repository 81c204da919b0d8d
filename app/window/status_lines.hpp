// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QWidget>
#include <vector>

#include "app/window/moment.hpp"

namespace nav::app {

/// One line for each input: shape, name and word of its state, age, rate, drops, cause. The last
/// line says what the session itself has to say.
class StatusLines final : public QWidget {
 public:
  explicit StatusLines(QWidget* parent);
  void show_inputs(const std::vector<InputStatus>& inputs, const QString& notice, Timestamp now);
  [[nodiscard]] const std::vector<InputStatus>& inputs() const { return inputs_; }
  [[nodiscard]] const QString& notice() const { return notice_; }
  /// Height of its lines.
  [[nodiscard]] int wanted_height() const;
  /// True: a text was cut when the lines were painted last.
  [[nodiscard]] bool clipped() const { return !fits_; }

 private:
  void paintEvent(QPaintEvent* event) override;

  std::vector<InputStatus> inputs_;
  QString notice_;
  Timestamp now_{};
  bool fits_ = true;
};

}  // namespace nav::app
