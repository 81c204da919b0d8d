// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QKeyEvent>
#include <QString>
#include <functional>
#include <optional>
#include <vector>

#include "nav/time.hpp"

namespace nav::app {

/// One action of the window and its key.
struct Action {
  QString name;   ///< Stable: "freeze".
  QString title;  ///< Its effect in words: "freeze or go live".
  QKeySequence key;
  std::function<void()> run;
};

/// The actions of the window. Foot switches are keyboards: a repeated key is ignored, and two
/// presses within 150 ms count once.
class Actions {
 public:
  void add(Action action) { all_.push_back(std::move(action)); }
  [[nodiscard]] const std::vector<Action>& all() const { return all_; }
  /// Runs the action of a key. True: the key has one, whether or not it ran.
  bool press(const QKeyEvent& event, Timestamp now);

 private:
  std::vector<Action> all_;
  struct Pressed {
    const Action* action;
    Timestamp at;
  };
  std::optional<Pressed> last_;
};

}  // namespace nav::app
