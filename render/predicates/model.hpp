// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "render/predicates/histogram.hpp"

namespace nav::render {

/// How deep combinations are nested, at most.
inline constexpr int kDeepestCombination = 16;

/// A point predicate or a combination of some (§3.2). A plain value.
struct PredicateExpression {
  enum class Operator {
    kKind,  ///< A predicate of the library.
    kNot,   ///< Of one operand.
    kAnd,   ///< Of one or more.
    kOr,
    kEntry,  ///< Whatever another entry of the model says.
  };
  Operator op = Operator::kKind;
  std::string name;            ///< Of the kind or the entry.
  std::vector<double> values;  ///< Parameters of a kind, in their order; empty: the initial ones.
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
  static PredicateExpression all(std::vector<PredicateExpression> of) {
    return {Operator::kAnd, {}, {}, std::move(of)};
  }
  static PredicateExpression any(std::vector<PredicateExpression> of) {
    return {Operator::kOr, {}, {}, std::move(of)};
  }
};
bool operator==(const PredicateExpression& a, const PredicateExpression& b);

struct PredicateEntry {
  std::string name;  ///< What the user calls it; each once.
  PredicateExpression expression;
};
bool operator==(const PredicateEntry& a, const PredicateEntry& b);

/// A predicate set-up: which predicates, and how important and in which colour each is. It belongs
/// to no data set: what a preset is. n of Eq. 6 is the number of entries. A plain value.
struct PredicateModel {
  std::vector<PredicateEntry> entries;
  PredicateHistogram histogram;  ///< A bar for each entry, in order.
};
bool operator==(const PredicateModel& a, const PredicateModel& b);
/// Whether two ask the same predicates in the same combinations, whatever their parameters, names,
/// importances and colours.
bool same_set(const PredicateModel& a, const PredicateModel& b);

/// Refuses, naming the entry: other than 1 to kMostPredicates entries, another number of bars,
/// names that are empty or twice there, kinds that there are not, parameters out of their ranges or
/// inverted, operators without operands, nesting deeper than kDeepestCombination, entries that are
/// not there or that refer to themselves through others.
Result<void> validate(const PredicateModel& model);

/// Names of the predicates of the library that a model asks.
std::set<std::string> kinds_of(const PredicateModel& model);

/// Names of the built-in set-ups, in the order of listings.
std::vector<std::string> predicate_preset_names();
/// A built-in set-up; kNotFound lists them.
Result<PredicateModel> preset_predicates(const std::string& name);

}  // namespace nav::render
