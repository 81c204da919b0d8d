// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace nav::render {

/// What is known of a predicate over a set of samples: false for all, true for all, or neither.
/// Ordered, so that AND is the minimum and OR the maximum (Kleene's strong three-valued logic).
enum class Truth { kFalse, kUnknown, kTrue };

inline Truth truth_of(bool value) { return value ? Truth::kTrue : Truth::kFalse; }
inline Truth not_of(Truth a) { return a == Truth::kUnknown ? a : truth_of(a == Truth::kFalse); }
inline Truth and_of(Truth a, Truth b) { return std::min(a, b); }
inline Truth or_of(Truth a, Truth b) { return std::max(a, b); }

/// Closed range of numbers; low <= high.
struct Range {
  double low;
  double high;
};

/// Whether a value anywhere in found lies in the closed range wanted.
inline Truth within(const Range& found, const Range& wanted) {
  if (found.low > wanted.high || found.high < wanted.low) return Truth::kFalse;
  return found.low >= wanted.low && found.high <= wanted.high ? Truth::kTrue : Truth::kUnknown;
}

}  // namespace nav::render
