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

TEST_F(NumeralsTest, TheDistanceToAStructureIsShownOnlyWhileItIsKnown) {
  using State = session::NearestStructure::State;
  const auto numerals = made();
  EXPECT_EQ(numerals->value("structure"), QLatin1String("none"));
  numerals->expect_structures(true);
  session::GuidanceError error = some_error();
  error.tip_mm = 2.01;
  numerals->show_numbers(kGuidance, error, "",
                         session::NearestStructure{State::kKnown, 7.26, "vessel", ""});
  EXPECT_EQ(numerals->value("structure"), QLatin1String("7.3"));
  EXPECT_EQ(numerals->value("structure-error"), QLatin1String("2.1"));
  EXPECT_EQ(numerals->value("structure-state"), QLatin1String("clear"));
  numerals->show_numbers(kGuidance, error, "",
                         session::NearestStructure{State::kKnown, 2, "vessel", "vessel"});
  EXPECT_EQ(numerals->value("structure-state"), QLatin1String("too-near"));
  for (const State state : {State::kPending, State::kUnknown}) {
    numerals->show_numbers(kGuidance, error, "", session::NearestStructure{.state = state});
    EXPECT_EQ(numerals->value("structure"), QLatin1String("withdrawn"));
    EXPECT_EQ(numerals->value("structure-error"), QLatin1String("withdrawn"));
    EXPECT_EQ(numerals->value("tip"), QLatin1String("12.3")) << "the others stay";
  }
  numerals->show_numbers(kGuidance, error, "", session::NearestStructure{.state = State::kFar});
  EXPECT_EQ(numerals->value("structure"), QLatin1String("far"));
  numerals->show_numbers(std::nullopt, error, "the needle is lost",
                         session::NearestStructure{State::kKnown, 7, "vessel", ""});
  EXPECT_EQ(numerals->value("structure"), QLatin1String("withdrawn"));
}

}  // namespace
}  // namespace nav::app
