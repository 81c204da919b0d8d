// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <utility>
#include <vector>

namespace nav::render {

/// A value that a user edits, with the values before and after for undo and redo. Above
/// kMostUndoSteps the oldest step is forgotten. One thread.
template <class T>
class UndoHistory {
 public:
  static constexpr std::size_t kMostUndoSteps = 100;

  UndoHistory() = default;
  explicit UndoHistory(T value) : value_(std::move(value)) {}

  [[nodiscard]] const T& value() const { return value_; }
  /// Sets the value: a step of its own, or part of the step of begin().
  void change(T value) {
    if (!open_ || !began_) {
      past_.push_back(std::move(value_));
      if (past_.size() > kMostUndoSteps) past_.pop_front();
      future_.clear();
      began_ = true;
    }
    value_ = std::move(value);
  }
  /// Sets the value without a step: undo() goes to the value before as if this were the step's own
  /// result.
  void amend(T value) { value_ = std::move(value); }
  /// From here to end(), all changes are one step: a drag.
  void begin() {
    open_ = true;
    began_ = false;
  }
  void end() { open_ = false; }
  /// False: there is no step before.
  bool undo() {
    end();
    if (past_.empty()) return false;
    future_.push_back(std::exchange(value_, std::move(past_.back())));
    past_.pop_back();
    return true;
  }
  /// False: no step was undone, or another change came since.
  bool redo() {
    end();
    if (future_.empty()) return false;
    past_.push_back(std::exchange(value_, std::move(future_.back())));
    future_.pop_back();
    return true;
  }
  [[nodiscard]] bool can_undo() const { return !past_.empty(); }
  [[nodiscard]] bool can_redo() const { return !future_.empty(); }

 private:
  T value_{};
  std::deque<T> past_;
  std::vector<T> future_;
  bool open_ = false;
  bool began_ = false;
};

}  // namespace nav::render
