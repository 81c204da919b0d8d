// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include "nav/result.hpp"
#include "nav/transform.hpp"

namespace nav::test {

/// Both parts of the difference stay within mm and rad; prints expected, actual and difference.
template <class To, class From>
::testing::AssertionResult is_near(const Transform<To, From>& actual,
                                   const Transform<To, From>& expected, double mm, double rad) {
  const double distance_mm = (actual.translation_mm() - expected.translation_mm()).norm();
  const double angle_rad = rotation_distance_rad(actual, expected);
  if (distance_mm <= mm && angle_rad <= rad) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << "actual\n"
         << actual.matrix() << "\nexpected\n"
         << expected.matrix() << "\ndifference " << distance_mm << " mm (limit " << mm << "), "
         << angle_rad << " rad (limit " << rad << ")";
}

/// A Result holds a value; otherwise prints its error.
template <class T>
::testing::AssertionResult has_value(const Result<T>& result) {
  if (result) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << to_string(result.error().code) << ": " << result.error().message;
}

/// A Result is a refusal of a kind whose one-line message contains every given piece.
template <class T>
::testing::AssertionResult refuses(const Result<T>& result, ErrorCode code,
                                   std::initializer_list<std::string> pieces) {
  if (result) return ::testing::AssertionFailure() << "expected an error, found a value";
  const Error& error = result.error();
  if (error.code != code) {
    return ::testing::AssertionFailure() << "expected code " << to_string(code) << ", found "
                                         << to_string(error.code) << ": " << error.message;
  }
  if (error.message.find('\n') != std::string::npos) {
    return ::testing::AssertionFailure() << "the message is not one line: " << error.message;
  }
  for (const std::string& piece : pieces) {
    if (error.message.find(piece) == std::string::npos) {
      return ::testing::AssertionFailure()
             << "expected the message to name '" << piece << "', found: " << error.message;
    }
  }
  return ::testing::AssertionSuccess();
}

}  // namespace nav::test
