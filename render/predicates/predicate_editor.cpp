// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/predicate_editor.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "nav/check.hpp"
#include "render/predicates/registry.hpp"

namespace nav::render {
namespace {

using Expression = PredicateExpression;

constexpr double kMostConnectedMm3 = 1e9;

/// Calls visit(kind or null, values) for the parts of an expression that have parameters, from left
/// to right. Fills in initial values.
template <class Visit>
void for_each_values(Expression& e, const Visit& visit) {
  if (e.op == Expression::Operator::kKind) {
    const auto kind = find_predicate_kind(e.name);
    if (!kind) return;
    if (e.values.empty()) {
      for (const auto& parameter : (*kind)->parameters()) e.values.push_back(parameter.initial);
    }
    visit(*kind, e.values);
  } else if (e.op == Expression::Operator::kConnected) {
    visit(static_cast<const PredicateKind*>(nullptr), e.values);
  }
  for (Expression& operand : e.operands) for_each_values(operand, visit);
}

PredicateParameter connected_parameter() {
  return {.name = "least_mm3", .unit = "mm3", .low = 0, .high = kMostConnectedMm3, .initial = 0};
}

Error out_of_range(const std::string& name, double low, double high, double found) {
  std::ostringstream text;
  text.precision(12);
  text << name << ": expected a number of " << low << " to " << high << ", found " << found;
  return {ErrorCode::kUsage, text.str()};
}

/// The expression with every reference to an entry replaced.
Expression with_replaced(Expression e, const std::string& name, const Expression& by) {
  if (e.op == Expression::Operator::kEntry && e.name == name) return by;
  for (Expression& operand : e.operands) operand = with_replaced(std::move(operand), name, by);
  return e;
}

/// A name that no entry has: "intensity", "intensity 2", …
std::string free_name(const PredicateModel& model, const std::string& wanted) {
  const auto taken = [&](const std::string& name) {
    return std::ranges::any_of(model.entries,
                               [&](const PredicateEntry& entry) { return entry.name == name; });
  };
  std::string name = wanted;
  for (int n = 2; taken(name); ++n) name = wanted + " " + std::to_string(n);
  return name;
}

/// A hue that lies far from those of the bars: turns by the golden angle.
double next_hue_deg(std::size_t bars) {
  constexpr double kGoldenAngleDeg = 137.50776405003785;
  return std::fmod(kGoldenAngleDeg * static_cast<double>(bars), 360);
}

}  // namespace

std::vector<EditableParameter> editable_parameters(const PredicateExpression& expression) {
  std::vector<EditableParameter> all;
  Expression copy = expression;
  for_each_values(copy, [&](const PredicateKind* kind, const std::vector<double>& values) {
    if (kind == nullptr) {
      all.push_back({"connected", connected_parameter(), values.front()});
      return;
    }
    const auto parameters = kind->parameters();
    for (std::size_t i = 0; i < parameters.size() && i < values.size(); ++i) {
      all.push_back({kind->name(), parameters[i], values[i]});
    }
  });
  return all;
}

PredicateEditor::PredicateEditor(PredicateModel model)
    : history_(State{.model = std::move(model)}) {}

std::optional<std::size_t> PredicateEditor::selected() const {
  if (model().entries.empty()) return std::nullopt;
  return history_.value().selected;
}

void PredicateEditor::select(std::size_t bar) {
  NAV_CHECK(bar < model().entries.size(), bar, model().entries.size());
  State state = history_.value();
  state.selected = bar;
  history_.amend(std::move(state));
}

void PredicateEditor::clamp_selected() {
  State state = history_.value();
  const std::size_t bars = state.model.entries.size();
  state.selected = bars == 0 ? 0 : std::min(state.selected, bars - 1);
  history_.amend(std::move(state));
}

void PredicateEditor::change(PredicateModel model, std::size_t selected) {
  history_.change(State{.model = std::move(model), .selected = selected});
  clamp_selected();
  ++revision_;
}

void PredicateEditor::drag(std::size_t bar, double importance) {
  NAV_CHECK(bar < model().entries.size(), bar, model().entries.size());
  PredicateModel next = model();
  next.histogram.drag(bar, importance);
  change(std::move(next), bar);
}

void PredicateEditor::set_colour(std::size_t bar, double hue_deg, double saturation) {
  NAV_CHECK(bar < model().entries.size(), bar, model().entries.size());
  PredicateModel next = model();
  next.histogram.set_colour(bar, hue_deg, saturation);
  change(std::move(next), bar);
}

Result<void> PredicateEditor::change_expression(std::size_t bar, PredicateExpression expression) {
  NAV_CHECK(bar < model().entries.size(), bar, model().entries.size());
  PredicateModel next = model();
  next.entries[bar].expression = std::move(expression);
  if (auto ok = validate(next); !ok) return Error{ErrorCode::kUsage, ok.error().message};
  change(std::move(next), bar);
  return {};
}

Result<void> PredicateEditor::set_parameter(std::size_t bar, std::size_t index, double value) {
  NAV_CHECK(bar < model().entries.size(), bar, model().entries.size());
  Expression expression = model().entries[bar].expression;
  const auto all = editable_parameters(expression);
  NAV_CHECK(index < all.size(), index, all.size());
  const PredicateParameter& parameter = all[index].parameter;
  if (!(value >= parameter.low && value <= parameter.high)) {
    return out_of_range(parameter.name, parameter.low, parameter.high, value);
  }
  std::size_t at = 0;
  for_each_values(expression, [&](const PredicateKind*, std::vector<double>& values) {
    if (index >= at && index < at + values.size()) values[index - at] = value;
    at += values.size();
  });
  return change_expression(bar, std::move(expression));
}

Result<void> PredicateEditor::set_floor(std::size_t bar, double floor) {
  NAV_CHECK(bar < model().entries.size(), bar, model().entries.size());
  if (!(floor >= 0 && floor <= 1)) return out_of_range("floor", 0, 1, floor);
  PredicateModel next = model();
  next.entries[bar].floor = floor;
  change(std::move(next), bar);
  return {};
}

Result<void> PredicateEditor::append(std::string name, PredicateExpression expression) {
  PredicateModel next = model();
  if (next.entries.size() >= kMostPredicates) {
    return Error{ErrorCode::kUsage, "predicates: expected at most " +
                                        std::to_string(kMostPredicates) +
                                        " in a set, which is full; remove one first"};
  }
  constexpr double kNewSaturation = 0.6;
  next.entries.push_back({free_name(next, name), std::move(expression)});
  next.histogram.add(next_hue_deg(next.entries.size() - 1), kNewSaturation);
  if (auto ok = validate(next); !ok) return Error{ErrorCode::kUsage, ok.error().message};
  const std::size_t last = next.entries.size() - 1;
  change(std::move(next), last);
  return {};
}

Result<void> PredicateEditor::add(const std::string& kind) {
  const auto found = find_predicate_kind(kind);
  if (!found) return found.error();
  return append(kind, Expression::kind(kind));
}

void PredicateEditor::remove(std::size_t bar) {
  NAV_CHECK(bar < model().entries.size(), bar, model().entries.size());
  PredicateModel next = model();
  const PredicateEntry gone = next.entries[bar];
  next.entries.erase(next.entries.begin() + static_cast<std::ptrdiff_t>(bar));
  next.histogram.remove(bar);
  for (PredicateEntry& entry : next.entries) {
    entry.expression = with_replaced(std::move(entry.expression), gone.name, gone.expression);
  }
  const std::size_t chosen = history_.value().selected;
  change(std::move(next), chosen > bar ? chosen - 1 : chosen);
}

Result<void> PredicateEditor::negate(std::size_t bar) {
  NAV_CHECK(bar < model().entries.size(), bar, model().entries.size());
  const Expression& now = model().entries[bar].expression;
  return change_expression(
      bar, now.op == Operator::kNot ? now.operands.front() : Expression::negation(now));
}

Result<void> PredicateEditor::combine(Operator op, std::size_t first, std::size_t second) {
  const std::size_t bars = model().entries.size();
  NAV_CHECK(op == Operator::kAnd || op == Operator::kOr, static_cast<int>(op));
  NAV_CHECK(first < bars && second < bars, first, second, bars);
  const PredicateEntry& a = model().entries[first];
  const PredicateEntry& b = model().entries[second];
  const bool both = op == Operator::kAnd;
  std::vector<Expression> operands{a.expression, b.expression};
  return append(a.name + (both ? " and " : " or ") + b.name,
                both ? Expression::all(std::move(operands)) : Expression::any(std::move(operands)));
}

void PredicateEditor::replace(PredicateModel model) { change(std::move(model), 0); }

PredicateModel PredicateEditor::before_strokes() const {
  PredicateModel before = model();
  if (!strokes().empty()) before.histogram = history_.value().before;
  return before;
}

void PredicateEditor::add_stroke(features::Stroke stroke) {
  State next = history_.value();
  if (next.strokes.empty()) next.before = next.model.histogram;
  next.strokes.push_back(std::move(stroke));
  history_.change(std::move(next));
  ++revision_;
}

void PredicateEditor::clear_strokes() {
  if (strokes().empty()) return;
  change(model(), history_.value().selected);
}

bool PredicateEditor::finish_scribble(std::uint64_t revision, PredicateHistogram histogram) {
  if (revision != revision_ || histogram.size() != model().entries.size()) return false;
  State next = history_.value();
  next.model.histogram = std::move(histogram);
  history_.amend(std::move(next));
  return true;
}

bool PredicateEditor::undo() {
  if (!history_.undo()) return false;
  ++revision_;
  return true;
}

bool PredicateEditor::redo() {
  if (!history_.redo()) return false;
  ++revision_;
  return true;
}

}  // namespace nav::render
