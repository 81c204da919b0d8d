// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/model.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <tuple>

#include "render/predicates/registry.hpp"

namespace nav::render {
namespace {

using Operator = PredicateExpression::Operator;

Result<void> check_values(const std::string& entry, const PredicateExpression& e) {
  const auto kind = find_predicate_kind(e.name);
  if (!kind) return Error{kind.error().code, entry + ": " + kind.error().message};
  const auto parameters = (*kind)->parameters();
  if (e.values.empty()) return {};
  if (e.values.size() != parameters.size()) {
    return malformed_predicates(entry + ": " + e.name + ": expected " +
                                std::to_string(parameters.size()) + " parameters, found " +
                                std::to_string(e.values.size()));
  }
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const PredicateParameter& p = parameters[i];
    if (e.values[i] >= p.low && e.values[i] <= p.high) continue;
    std::ostringstream text;
    text.precision(12);
    text << entry << ": " << e.name << "." << p.name << ": expected a number in [" << p.low << ", "
         << p.high << "], found " << e.values[i];
    return malformed_predicates(text.str());
  }
  if (const auto ok = (*kind)->check(e.values); !ok) {
    return Error{ok.error().code, entry + ": " + ok.error().message};
  }
  return {};
}

/// Checks expressions and the entries that they refer to.
class Checker {
 public:
  explicit Checker(const PredicateModel& model) : model_(model) {}

  Result<void> check(const PredicateEntry& entry) {
    path_ = {entry.name};
    return visit(entry.expression, 0);
  }

 private:
  Result<void> visit(const PredicateExpression& e, int depth) {
    const std::string& name = path_.front();
    if (depth > kDeepestCombination) {
      return malformed_predicates(name + ": expected combinations nested at most " +
                                  std::to_string(kDeepestCombination) + " deep, found deeper ones");
    }
    if (e.op == Operator::kKind) return check_values(name, e);
    if (e.op == Operator::kEntry) return follow(e.name);
    const std::size_t count = e.operands.size();
    const bool one = e.op == Operator::kNot || e.op == Operator::kConnected;
    if (count == 0 || (one && count != 1)) {
      return malformed_predicates(name + ": expected " +
                                  (e.op == Operator::kNot ? "one operand of NOT"
                                   : one                  ? "one operand of connected"
                                                          : "operands of AND or OR") +
                                  ", found " + std::to_string(count));
    }
    constexpr double kMostMm3 = 1e9;
    if (e.op == Operator::kConnected &&
        !(e.values.size() == 1 && e.values[0] >= 0 && e.values[0] <= kMostMm3)) {
      std::ostringstream text;
      text << name << ": connected.least_mm3: expected a number in [0, 1e9], found "
           << (e.values.empty() ? 0.0 : e.values[0]);
      return malformed_predicates(text.str());
    }
    for (const auto& operand : e.operands) {
      if (const auto ok = visit(operand, depth + 1); !ok) return ok;
    }
    return {};
  }

  Result<void> follow(const std::string& name) {
    if (std::find(path_.begin(), path_.end(), name) != path_.end()) {
      std::string cycle;
      for (const auto& step : path_) cycle += "\"" + step + "\" -> ";
      return malformed_predicates("predicates: expected combinations without a cycle, found " +
                                  cycle + "\"" + name + "\"");
    }
    if (good_.count(name) != 0) return {};  // Several references may lead to one entry.
    for (const PredicateEntry& entry : model_.entries) {
      if (entry.name != name) continue;
      path_.push_back(name);
      const auto ok = visit(entry.expression, 0);
      path_.pop_back();
      if (ok) good_.insert(name);
      return ok;
    }
    return malformed_predicates(path_.front() + ": expected the name of an entry, found \"" + name +
                                "\"");
  }

  const PredicateModel& model_;
  std::vector<std::string> path_;
  std::set<std::string> good_;
};

bool same_combination(const PredicateExpression& a, const PredicateExpression& b) {
  return std::tie(a.op, a.name) == std::tie(b.op, b.name) &&
         std::equal(a.operands.begin(), a.operands.end(), b.operands.begin(), b.operands.end(),
                    same_combination);
}

}  // namespace

bool operator==(const PredicateExpression& a, const PredicateExpression& b) {
  return std::tie(a.op, a.name, a.values, a.operands) ==
         std::tie(b.op, b.name, b.values, b.operands);
}
bool operator==(const PredicateEntry& a, const PredicateEntry& b) {
  return a.name == b.name && a.expression == b.expression && a.floor == b.floor;
}
bool operator==(const PredicateModel& a, const PredicateModel& b) {
  return a.entries == b.entries && a.histogram.bars() == b.histogram.bars();
}

bool same_set(const PredicateModel& a, const PredicateModel& b) {
  return std::equal(a.entries.begin(), a.entries.end(), b.entries.begin(), b.entries.end(),
                    [](const PredicateEntry& x, const PredicateEntry& y) {
                      return same_combination(x.expression, y.expression);
                    });
}

Result<void> validate(const PredicateModel& model) {
  const std::size_t count = model.entries.size();
  if (count < 1 || count > kMostPredicates) {
    return malformed_predicates("predicates: expected 1 to " + std::to_string(kMostPredicates) +
                                ", found " + std::to_string(count));
  }
  if (model.histogram.size() != count) {
    return malformed_predicates("predicates: expected a bar for each of " + std::to_string(count) +
                                " entries, found " + std::to_string(model.histogram.size()));
  }
  std::set<std::string> names;
  for (const PredicateEntry& entry : model.entries) {
    if (entry.name.empty() || !names.insert(entry.name).second) {
      return malformed_predicates("predicates: expected a unique name for each entry, found \"" +
                                  entry.name + "\"");
    }
    if (!(entry.floor >= 0 && entry.floor <= 1)) {
      std::ostringstream text;
      text << entry.name << ": floor: expected a number in [0, 1], found " << entry.floor;
      return malformed_predicates(text.str());
    }
  }
  Checker checker(model);
  for (const PredicateEntry& entry : model.entries) {
    if (const auto ok = checker.check(entry); !ok) return ok;
  }
  return {};
}

namespace {

void collect_kinds(const PredicateExpression& e, std::set<std::string>& names) {
  if (e.op == PredicateExpression::Operator::kKind) names.insert(e.name);
  for (const auto& operand : e.operands) collect_kinds(operand, names);
}

}  // namespace

std::set<std::string> kinds_of(const PredicateModel& model) {
  std::set<std::string> names;
  for (const auto& entry : model.entries) collect_kinds(entry.expression, names);
  return names;
}

}  // namespace nav::render
