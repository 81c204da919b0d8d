// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/cause_words.hpp"

#include <gtest/gtest.h>

namespace nav {
namespace {

TEST(CauseWordsTest, SaysCausesAsPeopleDo) {
  EXPECT_EQ(words_of_cause("no_listener"), "nothing listens there");
  EXPECT_EQ(words_of_cause("no_timestamp"), "there is no time stamp");
  EXPECT_EQ(words_of_cause("Probe.not_tracked"), "the probe is not tracked");
  EXPECT_EQ(words_of_cause("Reference.before_first_pose"),
            "the patient reference had its first pose later");
  EXPECT_EQ(words_of_cause("Needle.off_path"), "the needle left its path");
}

TEST(CauseWordsTest, UnknownNamesLoseTheirUnderscores) {
  EXPECT_EQ(words_of_cause("tool_of_another_kind"), "tool of another kind");
  EXPECT_EQ(words_of_cause("Probe.some_thing"), "the probe: some thing");
  EXPECT_EQ(words_of_cause("Stylus.not_tracked"), "Stylus is not tracked");
  EXPECT_EQ(words_of_cause(""), "");
}

}  // namespace
}  // namespace nav
