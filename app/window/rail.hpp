// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QPushButton>
#include <QScrollArea>
#include <QWidget>
#include <array>
#include <functional>

namespace nav::app {

/// State of a step of the procedure.
enum class StepState { kToDo, kBusy, kDone, kFailed };
/// Mark and word of a step's state.
QString mark_of(StepState state);

inline constexpr int kStepCount = 7;
/// Names of the steps, in order.
extern const std::array<const char*, kStepCount> kStepNames;

/// The rail at the left: the steps with their states, Record (of live devices), Freeze and
/// Snapshot.
class Rail final : public QWidget {
 public:
  static constexpr int kLeastWidth = 190;

  /// with_record: can_record().
  Rail(bool with_record, QWidget* parent);
  /// The session has devices that can be recorded: shows the button.
  void can_record(bool can) { record_->setVisible(can); }
  /// Width at which no text of the buttons is cut.
  [[nodiscard]] int wanted_width() const;
  void set_step(int step, StepState state);
  void choose(int step);
  void set_frozen(bool frozen);
  /// True: devices are recorded now.
  void set_recording(bool recording);
  [[nodiscard]] StepState step(int step) const { return states_.at(index(step)); }

  std::function<void(int step)> chosen;
  std::function<void()> freeze, snapshot, record;

 private:
  static std::size_t index(int step) { return static_cast<std::size_t>(step); }
  void label(int step);

  QScrollArea* scroll_;
  std::array<QPushButton*, kStepCount> steps_{};
  std::array<StepState, kStepCount> states_{};
  QPushButton* record_;
  QPushButton* freeze_;
  QPushButton* snapshot_;
};

}  // namespace nav::app
