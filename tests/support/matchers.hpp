// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include "nav/result.hpp"
#include "nav/transform.hpp"

namespace nav::test {

/// Succeeds if the two poses differ by at most \p mm and \p rad. A failure prints both poses and
/// their difference.
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

/// Succeeds if the result holds a value. A failure prints the error.
template <class T>
::testing::AssertionResult has_value(const Result<T>& result) {
  if (result) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << to_string(result.error().code) << ": " << result.error().message;
}

/// Succeeds if the result is an error with \p code and a one-line message that contains every
/// string of \p pieces.
template <class T>
::testing::AssertionResult rejects(const Result<T>& result, ErrorCode code,
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
