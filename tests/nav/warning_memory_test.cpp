// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/warning_memory.hpp"

#include <gtest/gtest.h>

namespace nav {
namespace {

TEST(WarningMemoryTest, KeepsTheFirstAndHandsOutTheNewestOnce) {
  CollectingDiagnostics outer;
  WarningMemory memory(outer);
  memory.report(Severity::kInfo, "part", "a remark");
  EXPECT_EQ(memory.first(), "");
  EXPECT_EQ(memory.take_newest(), "");
  memory.report(Severity::kWarning, "part", "one");
  memory.report(Severity::kError, "part", "two");
  EXPECT_EQ(memory.first(), "one");
  EXPECT_EQ(memory.take_newest(), "two");
  EXPECT_EQ(memory.take_newest(), "");
  EXPECT_EQ(memory.first(), "one");
  EXPECT_EQ(outer.entries().size(), 3U) << "every report is passed on";
}

}  // namespace
}  // namespace nav
