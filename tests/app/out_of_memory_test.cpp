// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// A separate program, because its `new` fails for every large allocation.
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <iterator>
#include <new>
#include <string>

#include "app/options/command_line.hpp"
#include "app/options/exit_code.hpp"
#include "tests/support/test_data.hpp"

namespace {
constexpr std::size_t kMostBytes = std::size_t{32} << 20;
}  // namespace

// Not inlined: the compiler would see malloc() and delete as a mismatch.
__attribute__((noinline)) void* operator new(std::size_t bytes) {
  void* memory = bytes <= kMostBytes ? std::malloc(bytes) : nullptr;
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
__attribute__((noinline)) void operator delete(void* memory) noexcept { std::free(memory); }
__attribute__((noinline)) void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace nav::app {
namespace {

TEST(OutOfMemoryTest, IsReportedAsAnErrorNotAsABug) {
  const test::TemporaryFolder folder;
  const std::string out = (folder / "x.png").string();
  const char* const arguments[] = {"sonde",          "predicates", "--phantom", "neck",
                                   "--phantom-side", "384",        "--out",     out.c_str()};
  testing::internal::CaptureStderr();
  const int code = run_command_line(std::size(arguments), arguments);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(code, kExitDevice);
  EXPECT_NE(said.find("sonde: error: out of memory"), std::string::npos) << said;
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace nav::app
