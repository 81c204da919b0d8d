// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/numerals.hpp"

#include <gtest/gtest.h>

#include "tests/window/application.hpp"

namespace nav::app {
namespace {

const NeedleGuidance kGuidance{12.34, 12.0, 1.0, 0.1};

session::GuidanceError some_error() {
  session::GuidanceError error;
  error.tip_to_target_mm = 1.41;
  error.with = {"registration"};
  error.without = {"bending of the needle"};
  return error;
}

class NumeralsTest : public ::testing::Test {
 protected:
  NumeralsTest() { test::application(); }
  [[nodiscard]] std::unique_ptr<Numerals> made() const {
    return std::make_unique<Numerals>(nullptr);
  }
};

TEST_F(NumeralsTest, AnIntervalIsRoundedUpAndExplained) {
  const auto numerals = made();
  numerals->show_numbers(kGuidance, some_error(), "");
  EXPECT_EQ(numerals->value("tip"), QLatin1String("12.3"));
  EXPECT_EQ(numerals->value("tip-error"), QLatin1String("1.5"));
  EXPECT_EQ(numerals->value("depth-error"), QLatin1String("unknown"));
  EXPECT_TRUE(numerals->explanation().contains(QLatin1String("for these errors: registration")));
  EXPECT_TRUE(numerals->explanation().contains(QLatin1String("not in it: bending of the needle")));
}

TEST_F(NumeralsTest, UnknownErrorsAreSaid) {
  const auto numerals = made();
  numerals->show_numbers(kGuidance, std::nullopt, "");
  EXPECT_EQ(numerals->value("tip-error"), QLatin1String("unknown"));
  EXPECT_TRUE(numerals->explanation().contains(QLatin1String("not known")));
}

TEST_F(NumeralsTest, WithdrawnNumbersLeaveNothing) {
  const auto numerals = made();
  numerals->show_numbers(kGuidance, some_error(), "");
  numerals->show_numbers(std::nullopt, some_error(), "the needle is not tracked");
  for (const char* name : {"tip", "tip-error", "depth", "depth-error", "angle-error"}) {
    EXPECT_EQ(numerals->value(name), QLatin1String("withdrawn")) << name;
  }
  EXPECT_TRUE(numerals->explanation().contains(QLatin1String("the needle is not tracked")));
  EXPECT_EQ(numerals->value("speed"), QString());
}

}  // namespace
}  // namespace nav::app
