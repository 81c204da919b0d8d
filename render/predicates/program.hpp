// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/predicates/histogram.hpp"

namespace nav::render {

/// A Boolean combination in postfix order, for any logic with NOT, AND and OR: bools, three-valued
/// truths, lane masks.
struct PredicateProgram {
  enum class Op : std::uint8_t { kLeaf, kEntry, kNot, kAnd, kOr };
  struct Token {
    Op op;
    std::uint8_t index;  ///< Number of a leaf or an entry.
  };
  int entry;  ///< Entry that receives the result.
  std::vector<Token> tokens;
};

/// Greatest number of values on the stack of a program.
inline constexpr std::size_t kProgramStack = 64;

/// Runs programs in their order. leaf(i) is the value of a leaf; result[j] receives the value of
/// entry j.
template <class T, class Leaf, class Not, class And, class Or>
void run_programs(const std::vector<PredicateProgram>& programs, const Leaf& leaf,
                  const Not& negate, const And& both, const Or& either,
                  std::array<T, kMostPredicates>& result) {
  std::array<T, kProgramStack> stack;
  for (const PredicateProgram& program : programs) {
    std::size_t top = 0;
    for (const PredicateProgram::Token token : program.tokens) {
      switch (token.op) {
        case PredicateProgram::Op::kLeaf:
          stack[top++] = leaf(static_cast<int>(token.index));
          break;
        case PredicateProgram::Op::kEntry:
          stack[top++] = result[token.index];
          break;
        case PredicateProgram::Op::kNot:
          stack[top - 1] = negate(stack[top - 1]);
          break;
        case PredicateProgram::Op::kAnd:
          --top;
          stack[top - 1] = both(stack[top - 1], stack[top]);
          break;
        case PredicateProgram::Op::kOr:
          --top;
          stack[top - 1] = either(stack[top - 1], stack[top]);
          break;
      }
    }
    result[static_cast<std::size_t>(program.entry)] = stack[0];
  }
}

}  // namespace nav::render
