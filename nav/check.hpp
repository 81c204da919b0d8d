// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace nav {

/// An error of this program's own code, never a failure of the outside world. It is caught only at
/// thread roots in app/, which blank the overlay.
class Bug : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

namespace detail {
template <class... Values>
[[noreturn]] void fail_check(const char* condition, const char* file, int line,
                             const Values&... values) {
  std::ostringstream text;
  text << file << ':' << line << ": check failed: " << condition;
  ((text << " [" << values << ']'), ...);
  throw Bug(text.str());
}
}  // namespace detail

}  // namespace nav

/// Checks an invariant in every build. A failure throws nav::Bug with the condition and the given
/// values.
#define NAV_CHECK(condition, ...)                                                           \
  do {                                                                                      \
    if (!(condition)) {                                                                     \
      ::nav::detail::fail_check(#condition, __FILE__, __LINE__ __VA_OPT__(, ) __VA_ARGS__); \
    }                                                                                       \
  } while (false)
