// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace nav::render {

/// The truth of a predicate over a set of samples: false for all, true for all, or unknown. The
/// order makes AND the minimum and OR the maximum (Kleene's strong three-valued logic).
enum class Truth { kFalse, kUnknown, kTrue };

inline Truth truth_of(bool value) { return value ? Truth::kTrue : Truth::kFalse; }
inline Truth not_of(Truth a) { return a == Truth::kUnknown ? a : truth_of(a == Truth::kFalse); }
inline Truth and_of(Truth a, Truth b) { return std::min(a, b); }
inline Truth or_of(Truth a, Truth b) { return std::max(a, b); }

/// A closed range of numbers; low <= high.
struct Range {
  double low;
  double high;
};

/// Tells if all, none or some values of the range found can lie in the closed range wanted.
inline Truth within(const Range& found, const Range& wanted) {
  if (found.low > wanted.high || found.high < wanted.low) return Truth::kFalse;
  return found.low >= wanted.low && found.high <= wanted.high ? Truth::kTrue : Truth::kUnknown;
}

}  // namespace nav::render
