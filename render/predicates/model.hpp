// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "render/predicates/histogram.hpp"

namespace nav::render {

/// Greatest depth of nested combinations.
inline constexpr int kDeepestCombination = 16;

/// A point predicate or a combination of several (§3.2). A plain value.
struct PredicateExpression {
  enum class Operator {
    kKind,  ///< A predicate of the library.
    kNot,   ///< Negates one operand.
    kAnd,   ///< kAnd and kOr combine one or more operands.
    kOr,
    kEntry,  ///< Refers to another entry of the model.
    /// The operand, where it is true in a connected part of at least values[0] mm³: connected.hpp.
    kConnected,
  };
  Operator op = Operator::kKind;
  std::string name;            ///< Name of the kind or the entry.
  std::vector<double> values;  ///< Parameters of a kind, in order; empty: the initial values.
  std::vector<PredicateExpression> operands{};

  static PredicateExpression kind(std::string name, std::vector<double> values = {}) {
    return {Operator::kKind, std::move(name), std::move(values)};
  }
  static PredicateExpression entry(std::string name) {
    return {Operator::kEntry, std::move(name), {}};
  }
  static PredicateExpression negation(PredicateExpression of) {
    return {Operator::kNot, {}, {}, {std::move(of)}};
  }
  static PredicateExpression connected(PredicateExpression of, double least_mm3) {
    return {Operator::kConnected, {}, {least_mm3}, {std::move(of)}};
  }
  static PredicateExpression all(std::vector<PredicateExpression> of) {
    return {Operator::kAnd, {}, {}, std::move(of)};
  }
  static PredicateExpression any(std::vector<PredicateExpression> of) {
    return {Operator::kOr, {}, {}, std::move(of)};
  }
};
bool operator==(const PredicateExpression& a, const PredicateExpression& b);

struct PredicateEntry {
  std::string name;  ///< Unique name, given by the user.
  PredicateExpression expression;
  /// Least intensity, and with it least luminance and opacity, of voxels where it is true, [0, 1];
  /// 0: none. Applied by shaped_intensity().
  double floor = 0;
};
bool operator==(const PredicateEntry& a, const PredicateEntry& b);

/// A predicate set: the predicates, and the importance and the colour of each. It is independent of
/// data sets, so it also describes presets. n in Eq. 6 is the number of entries. A plain value.
struct PredicateModel {
  std::vector<PredicateEntry> entries;
  PredicateHistogram histogram;  ///< One bar for each entry, in order.
};
bool operator==(const PredicateModel& a, const PredicateModel& b);
/// True when two models have the same predicates in the same combinations. Parameters, names,
/// importances and colours may differ.
bool same_set(const PredicateModel& a, const PredicateModel& b);

/// Rejects the following and names the entry: fewer than 1 or more than kMostPredicates entries; a
/// different number of bars; empty or repeated names; unknown kinds; parameters that are out of
/// range or inverted; operators without operands; floors outside [0, 1]; connected parts outside
/// [0, 1e9] mm³; nesting deeper than kDeepestCombination; references to missing entries; cycles of
/// references.
Result<void> validate(const PredicateModel& model);

/// Names of the kinds of predicates that a model uses.
std::set<std::string> kinds_of(const PredicateModel& model);

/// Names of the built-in predicate sets, in the order of listings.
std::vector<std::string> predicate_preset_names();
/// A built-in predicate set. For an unknown name, the kNotFound error lists the names.
Result<PredicateModel> preset_predicates(const std::string& name);

}  // namespace nav::render
