// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/diagnostics.hpp"

#include <gtest/gtest.h>

#include "nav/warning_memory.hpp"

namespace nav {
namespace {

Finding spacing(const std::string& file, const std::string& by_sform) {
  return {.subject = file,
          .key = "spacing",
          .values = {"s-form " + by_sform, "pixdim 2 2 4 mm"},
          .used = "s-form"};
}

TEST(DiagnosticsTest, AFindingIsOneSentenceWithBothValuesAndWhatIsUsed) {
  Finding finding = spacing("ct.nii", "1 1 1 mm");
  EXPECT_EQ(sentence_of(finding),
            "ct.nii: spacing: s-form 1 1 1 mm against pixdim 2 2 4 mm; used: s-form");
  finding.values.pop_back();
  EXPECT_EQ(sentence_of(finding), "ct.nii: spacing: s-form 1 1 1 mm; used: s-form");
  finding.values = {"a", "b", "c"};
  EXPECT_EQ(sentence_of(finding), "ct.nii: spacing: a, b, c; used: s-form");
}

TEST(DiagnosticsTest, FindingsOfOneSubjectAndKeyAreCountedTogether) {
  CollectingDiagnostics collected;
  WarningMemory memory(collected);
  memory.report("io", spacing("a.nii", "1 1 1 mm"));
  memory.report("io", spacing("a.nii", "3 3 3 mm"));
  memory.report("io", spacing("b.nii", "1 1 1 mm"));
  memory.report(Severity::kWarning, "io", "a sentence");
  const auto entries = collected.entries();
  ASSERT_EQ(entries.size(), 3U);
  EXPECT_EQ(entries[0].count, 2U);
  EXPECT_EQ(entries[0].finding->values[0], "s-form 1 1 1 mm") << "the first is kept";
  EXPECT_EQ(entries[0].severity, Severity::kWarning);
  EXPECT_EQ(entries[1].finding->subject, "b.nii");
  EXPECT_FALSE(entries[2].finding.has_value());
  EXPECT_EQ(memory.first(), entries[0].message);
}

TEST(DiagnosticsTest, CountsWhatItHasNoRoomFor) {
  CollectingDiagnostics collected(1);
  collected.report(Severity::kInfo, "a", "one");
  collected.report(Severity::kInfo, "a", "two");
  collected.report(Severity::kInfo, "a", "one");
  EXPECT_EQ(collected.entries().size(), 1U);
  EXPECT_EQ(collected.entries()[0].count, 2U);
  EXPECT_EQ(collected.dropped(), 1U);
}

}  // namespace
}  // namespace nav
