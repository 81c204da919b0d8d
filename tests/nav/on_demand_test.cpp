// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/on_demand.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace nav {
namespace {

TEST(OnDemandTest, NamesALibraryThatIsNotThere) {
  EXPECT_TRUE(test::rejects(functions_on_demand("/nowhere/part.so", "part"),
                            ErrorCode::kUnavailable, {"/nowhere/part.so", "expected", "found"}));
}

TEST(OnDemandTest, NamesAFunctionThatALibraryDoesNotHave) {
  EXPECT_TRUE(test::rejects(functions_on_demand("libm.so.6", "no_such_part"),
                            ErrorCode::kUnavailable, {"libm.so.6", "no_such_part"}));
}

TEST(OnDemandTest, FindsLibrariesBesideTheProgramAndWhereTheyAreInstalled) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe");
  EXPECT_EQ(library_of_program(program.filename(), "../lib/sonde"), program);
  EXPECT_EQ(library_of_program("no_such.so", "../lib/sonde"),
            program.parent_path().parent_path() / "lib/sonde/no_such.so");
}

}  // namespace
}  // namespace nav
