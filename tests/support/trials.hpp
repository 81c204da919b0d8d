// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <concepts>
#include <initializer_list>
#include <vector>

namespace nav::test {

/// True under a sanitizer. A sanitizer looks for wrong memory accesses, not for wrong numbers, so
/// there tests repeat the same code with other numbers less often.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// Returns all values, under a sanitizer only the first.
template <class T>
std::vector<T> trials(std::initializer_list<T> all) {
  return kSanitized ? std::vector<T>{*all.begin()} : std::vector<T>(all);
}
/// Returns the number of trials, under a sanitizer an eighth of it (at least 1).
template <std::integral T>
constexpr T trials(T all) {
  return kSanitized ? std::max(T{1}, static_cast<T>(all / 8)) : all;
}

}  // namespace nav::test
