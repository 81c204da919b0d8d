// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <concepts>
#include <initializer_list>
#include <vector>

namespace nav::test {

/// A sanitizer looks for wrong accesses, not for wrong numbers: what runs the same code again for
/// other numbers is tried less often there.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// All of them, under a sanitizer the first.
template <class T>
std::vector<T> trials(std::initializer_list<T> all) {
  return kSanitized ? std::vector<T>{*all.begin()} : std::vector<T>(all);
}
/// So many, under a sanitizer an eighth.
template <std::integral T>
constexpr T trials(T all) {
  return kSanitized ? std::max(T{1}, static_cast<T>(all / 8)) : all;
}

}  // namespace nav::test
