// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QGridLayout>
#include <QScrollArea>
#include <QWidget>
#include <functional>
#include <optional>
#include <vector>

#include "app/window/brush.hpp"
#include "app/window/histogram_bars.hpp"
#include "app/window/small_controls.hpp"
#include "render/predicates/predicate_editor.hpp"

namespace nav::app {

/// The panel of the predicate histogram (Schulte zu Berge et al. 2014, Fig. 4): bars, sliders of
/// hue and saturation at their left, parameters of the chosen predicate below, combinations,
/// presets, and the brushes of the scribbles. It edits an editor and draws nothing else.
class PredicatePage final : public QWidget {
 public:
  /// The editor must outlive it.
  PredicatePage(render::PredicateEditor& editor, QWidget* parent);

  /// Shows the editor's set again, after a change from elsewhere.
  void refresh();
  /// With a volume whose predicates can be edited; without: the panel says that there is none.
  void set_volume(bool there);
  /// A sentence about the last edit; may be empty.
  void say(const QString& words);
  [[nodiscard]] QString words() const { return message_->text(); }
  [[nodiscard]] HistogramBars& bars() { return *bars_; }
  /// The brush in use; absent: none.
  [[nodiscard]] std::optional<Brush> brush() const;
  /// Ends the brush, or the choice of a second predicate. False: there was neither.
  bool cancel();
  bool undo();
  bool redo();

  std::function<void()> edited;         ///< The editor's set has changed.
  std::function<void()> brush_changed;  ///< Another brush, or none.
  /// A preset was chosen.
  std::function<void(const QString& name)> preset_chosen;

 private:
  void add_rows();
  QWidget* colour_and_bars();
  QWidget* combination_row();
  QWidget* scribble_row();
  void after(const Result<void>& done);
  void changed();
  void pick(std::size_t bar);
  void set_colour();
  void add_kind(int item);
  void rebuild_parameters();
  void combine_next(render::PredicateEditor::Operator op);
  void choose_brush(int which);

  render::PredicateEditor& editor_;
  HistogramBars* bars_;
  QComboBox* presets_;
  QComboBox* add_;
  QPushButton *undo_, *redo_, *remove_, *not_, *and_, *or_;
  QSlider *hue_, *saturation_;
  QScrollArea* parameters_;
  QLabel* message_;
  std::vector<QPushButton*> brushes_;  ///< Show, hide, erase.
  QPushButton* clear_;
  QDoubleSpinBox* radius_;
  /// The first operand while the second one is chosen.
  struct Combining {
    render::PredicateEditor::Operator op;
    std::size_t first;
  };
  std::optional<Combining> combining_;
  /// Parameters that are shown: rebuilt when the chosen expression is another one.
  std::vector<QDoubleSpinBox*> numbers_;
  std::vector<render::EditableParameter> shown_;
};

}  // namespace nav::app
