// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QWidget>
#include <functional>
#include <optional>
#include <vector>

#include "app/window/small_controls.hpp"
#include "nav/plan.hpp"
#include "render/undo_history.hpp"
#include "session/critical_structures.hpp"

namespace nav::app {

/// A plan in the making, which may lack parts.
struct PlanDraft {
  std::optional<Point<frames::Ct>> target{}, entry{};
  double radius_mm = 5;
  double margin_mm = 5;
  std::vector<session::CriticalStructure> structures{};

  /// Absent: a part is missing, or entry and target are the same point.
  [[nodiscard]] std::optional<NeedlePlan> plan() const;
};

/// Controls of the step Plan: target and entry from the cursor or by the next click, critical
/// structures, and the path checked against them.
class PlanPage final : public QWidget {
 public:
  enum class Pick { kNone, kTarget, kEntry };

  explicit PlanPage(QWidget* parent);

  /// Begins with the plan of a session.
  void open(PlanDraft draft);
  [[nodiscard]] const PlanDraft& draft() const { return history_.value(); }
  /// The part that the next click in a view sets.
  [[nodiscard]] Pick pick() const;
  /// Sets the part of pick(), which ends, or a part by name.
  void picked(const Point<frames::Ct>& point);
  void set(Pick part, const Point<frames::Ct>& point);
  /// Ends pick(). False: there was none.
  bool cancel();
  bool undo();
  bool redo();
  /// The result of session::check_path(); absent: there is no path.
  void show_check(const std::optional<session::PathCheck>& check);
  [[nodiscard]] const std::optional<session::PathCheck>& check() const { return check_; }

  std::function<void()> edited;  ///< The draft has changed.
  std::function<void()> pick_changed;
  std::function<std::optional<Point<frames::Ct>>()> cursor;  ///< The cursor of the slices.

 private:
  void change(PlanDraft draft);
  void refresh();
  void add_structure(bool sphere);
  void remove_structure();
  void from_cursor(Pick part);

  render::UndoHistory<PlanDraft> history_;
  std::optional<session::PathCheck> check_;
  QPushButton *target_, *entry_, *pick_target_, *pick_entry_, *undo_, *redo_;
  QDoubleSpinBox *radius_, *margin_, *size_, *clearance_, *low_, *high_;
  QComboBox* structures_;
  QPushButton *add_sphere_, *add_values_, *remove_;
  QLabel* words_;
};

}  // namespace nav::app
