// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QCheckBox>
#include <QWidget>
#include <functional>

#include "app/views/flat_views.hpp"
#include "app/window/small_controls.hpp"

namespace nav::app {

/// Controls of the step Registration: landmarks, the sweep, by eye, overlay, and the user's
/// verdict. It shows and asks; RegistrationDesk does the work.
class RegistrationPage final : public QWidget {
 public:
  /// A movement of the CT by the user: steps along or about an axis of the patient (LPS).
  struct Nudge {
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  };

  explicit RegistrationPage(QWidget* parent);

  /// Names of the landmarks; a chosen one stays chosen.
  void show_landmarks(const QStringList& names);
  [[nodiscard]] int chosen_landmark() const { return landmarks_->currentIndex(); }
  void say(const QString& words) { words_->setText(words); }
  [[nodiscard]] QString words() const { return words_->text(); }
  /// runs: a registration by the sweep is at work.
  void set_running(bool runs);
  /// A result waits for the user's verdict; acceptable: its limits allow to accept it. Reject is
  /// about the registration in use while none waits.
  void set_waiting(bool waits, bool acceptable);
  void set_undo(bool undo, bool redo);
  [[nodiscard]] bool by_eye() const { return eye_->isChecked(); }
  void set_by_eye(bool on) { eye_->setChecked(on); }
  [[nodiscard]] double step() const { return step_->value(); }
  [[nodiscard]] CtOverlay overlay() const;

  std::function<void()> point, touch, remove, fit, sweep, cancel, accept, reject, undo, redo;
  std::function<void(bool)> by_eye_changed, before;
  std::function<void(const Nudge&)> nudged;
  std::function<void(const CtOverlay&)> overlay_changed;

 private:
  QWidget* eye_rows();
  void ask(bool accepts);

  QComboBox* landmarks_;
  QPushButton *sweep_, *cancel_, *accept_, *reject_, *confirm_, *no_, *undo_, *redo_, *before_;
  QCheckBox* eye_;
  QDoubleSpinBox* step_;
  QComboBox* overlay_;
  QSlider* share_;
  QLabel* words_;
  bool accepts_ = false;  ///< The question that confirm_ answers.
};

}  // namespace nav::app
