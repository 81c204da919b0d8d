// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/played_recording.hpp"

#include <gtest/gtest.h>

namespace nav::session {
namespace {

TEST(DamageFindingTest, HoldsEverySentenceWithoutTheNameOfTheFile) {
  const Finding found =
      damage_finding("a.mcap", {"a.mcap: 3 chunks are damaged", "the index is missing"});
  EXPECT_EQ(found.subject, "a.mcap");
  EXPECT_EQ(found.key, "data of the recording");
  EXPECT_EQ(found.values, std::vector<std::string>{"3 chunks are damaged; the index is missing"});
  EXPECT_EQ(found.severity, Severity::kWarning);
}

}  // namespace
}  // namespace nav::session
