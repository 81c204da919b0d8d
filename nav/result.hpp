// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "nav/check.hpp"

namespace nav {

/// Kind of a failure of the outside world. It decides the exit code of the program.
enum class ErrorCode {
  kUsage,            ///< The caller asked for something that does not exist or contradicts itself.
  kNotFound,         ///< A file, folder or named thing is missing.
  kMalformedData,    ///< The input breaks its format, or its values are impossible.
  kUnsupportedData,  ///< The input is well-formed, but of a kind that is not handled.
  kIo,               ///< Reading or writing failed: permissions, disk full, broken pipe.
  kUnavailable,      ///< A device, driver or display does not exist or cannot be used.
  kTimeout,          ///< A deadline passed.
  kCancelled,        ///< The caller asked to stop.
  kEndOfStream,      ///< The source has no more data; not a failure.
  kRefused,          ///< A result was computed and judged not good enough to use.
  kNumerical,        ///< A computation has no finite or unique answer.
};

/// Stable lower-case name of a code, for reports.
const char* to_string(ErrorCode code);

/// A failure of the outside world. The message is one sentence that names the thing, what was
/// expected and what was found.
struct Error {
  ErrorCode code;
  std::string message;
};

/// Either a T or an Error (to become std::expected in C++23). Access to the absent one is a Bug.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT

  [[nodiscard]] bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  [[nodiscard]] const T& value() const& {
    NAV_CHECK(has_value(), std::get<1>(state_).message);
    return std::get<0>(state_);
  }
  [[nodiscard]] T& value() & {
    NAV_CHECK(has_value(), std::get<1>(state_).message);
    return std::get<0>(state_);
  }
  [[nodiscard]] T&& value() && {
    NAV_CHECK(has_value(), std::get<1>(state_).message);
    return std::get<0>(std::move(state_));
  }
  const T& operator*() const& { return value(); }
  T& operator*() & { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  const T* operator->() const { return &value(); }
  T* operator->() { return &value(); }

  [[nodiscard]] const Error& error() const {
    NAV_CHECK(!has_value());
    return std::get<1>(state_);
  }

 private:
  std::variant<T, Error> state_;
};

/// Success without a value, or an Error.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}  // NOLINT

  [[nodiscard]] bool has_value() const { return !error_.has_value(); }
  explicit operator bool() const { return has_value(); }
  [[nodiscard]] const Error& error() const {
    NAV_CHECK(error_.has_value());
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

}  // namespace nav
