// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "render/features/scribbles.hpp"
#include "render/predicates/kind.hpp"
#include "render/predicates/model.hpp"
#include "render/undo_history.hpp"

namespace nav::render {

/// A number of an expression that a user can set.
struct EditableParameter {
  std::string kind;  ///< Name of the predicate, or "connected".
  PredicateParameter parameter;
  double value;
};
/// Parameters of an expression: those of its predicates from left to right, and the volumes of its
/// connected parts.
std::vector<EditableParameter> editable_parameters(const PredicateExpression& expression);

/// Edits a predicate set as a user does in a predicate histogram (Schulte zu Berge et al. 2014
/// §3.3): bars, colours, parameters, combinations (§3.2) and scribbles (§4.1), with undo and redo.
/// After every edit the sum of the importances is 1, or there is no predicate, and the set is valid
/// or empty. Toolkit-free; one thread. Bars are indices below model().entries.size(); another one
/// is a Bug.
class PredicateEditor {
 public:
  using Operator = PredicateExpression::Operator;

  PredicateEditor() = default;
  /// Precondition: a valid model, or an empty one.
  explicit PredicateEditor(PredicateModel model);

  [[nodiscard]] const PredicateModel& model() const { return history_.value().model; }
  /// The bar whose colour and parameters are shown; absent in an empty set.
  [[nodiscard]] std::optional<std::size_t> selected() const;
  /// No step of undo.
  void select(std::size_t bar);

  /// Drags a bar to a height: PredicateHistogram::drag().
  void drag(std::size_t bar, double importance);
  void set_colour(std::size_t bar, double hue_deg, double saturation);
  /// Sets a parameter of editable_parameters(). kUsage, and no change: out of its range, or a range
  /// that would be inverted.
  Result<void> set_parameter(std::size_t bar, std::size_t index, double value);
  /// Sets PredicateEntry::floor. kUsage: outside [0, 1].
  Result<void> set_floor(std::size_t bar, double floor);
  /// Adds a last bar of the mean height for a predicate of the library with its initial values, and
  /// selects it. kNotFound for an unknown kind; kUsage when the set is full.
  Result<void> add(const std::string& kind);
  /// Removes a bar. Others that refer to it take over its expression.
  void remove(std::size_t bar);
  /// Negates the expression of a bar. A second call gives it back. kUsage: nested too deep.
  Result<void> negate(std::size_t bar);
  /// Adds a bar for kAnd or kOr of two others, which stay. kUsage: the set is full, or the
  /// combination is nested too deep.
  Result<void> combine(Operator op, std::size_t first, std::size_t second);
  /// Replaces the whole set, by a preset for example.
  void replace(PredicateModel model);

  /// Strokes since the last other change of the set, in order.
  [[nodiscard]] const std::vector<features::Stroke>& strokes() const {
    return history_.value().strokes;
  }
  /// The set as it was before these strokes: Eq. 9 starts from its histogram.
  [[nodiscard]] PredicateModel before_strokes() const;
  /// Adds a stroke. The histogram changes when its effect is known: finish_scribble().
  void add_stroke(features::Stroke stroke);
  /// Forgets the strokes; the histogram stays.
  void clear_strokes();
  /// Takes over the histogram that the strokes lead to, as part of the step of the last stroke.
  /// revision: revision() for which it was computed. False: the set has changed since.
  bool finish_scribble(std::uint64_t revision, PredicateHistogram histogram);

  /// All changes from begin() to end() are one step of undo: a drag of the mouse.
  void begin() { history_.begin(); }
  void end() { history_.end(); }
  bool undo();
  bool redo();
  [[nodiscard]] bool can_undo() const { return history_.can_undo(); }
  [[nodiscard]] bool can_redo() const { return history_.can_redo(); }
  /// Counts the changes.
  [[nodiscard]] std::uint64_t revision() const { return revision_; }

 private:
  struct State {
    PredicateModel model;
    std::size_t selected = 0;
    std::vector<features::Stroke> strokes{};
    PredicateHistogram before{};  ///< Bars before the strokes; unused without strokes.
  };
  /// A step; strokes belong to the histogram that they led to, and end.
  void change(PredicateModel model, std::size_t selected);
  Result<void> change_expression(std::size_t bar, PredicateExpression expression);
  Result<void> append(std::string name, PredicateExpression expression);
  void clamp_selected();

  UndoHistory<State> history_;
  std::uint64_t revision_ = 0;
};

}  // namespace nav::render
