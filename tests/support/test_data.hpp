// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <unistd.h>

namespace nav::test {

/// Folder of the third-party data: SONDE_DATA_DIR, or ../shared/data beside the checkout.
inline std::filesystem::path data_dir() {
  if (const char* dir = std::getenv("SONDE_DATA_DIR")) return dir;
  return std::filesystem::path(SONDE_SOURCE_DIR) / ".." / "shared" / "data";
}

/// Temporary folder. The destructor deletes it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    static std::atomic<int> counter{0};
    path_ = std::filesystem::temp_directory_path() /
            ("sonde_test_" + std::to_string(::getpid()) + "_" + std::to_string(counter++));
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace nav::test

/// Skips the test with a message if a file of the third-party data is missing.
#define SONDE_REQUIRE_DATA(variable, relative)                \
  const auto variable = ::nav::test::data_dir() / (relative); \
  if (!std::filesystem::exists(variable))                     \
  GTEST_SKIP() << "third-party data missing: " << variable << " (set SONDE_DATA_DIR)"
