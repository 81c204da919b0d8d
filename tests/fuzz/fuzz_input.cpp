// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/fuzz_input.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <unistd.h>

namespace nav::fuzz {
namespace {

/// Folder of this process; it is removed at the end.
class Folder {
 public:
  Folder() {
    const bool memory = std::filesystem::is_directory("/dev/shm");
    path_ = std::filesystem::path(memory ? "/dev/shm" : "/tmp") /
            ("sonde-fuzz-" + std::to_string(::getpid()));
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace

std::filesystem::path as_file(const std::uint8_t* bytes, std::size_t size, std::string_view name) {
  static const Folder folder;
  static std::filesystem::path before;
  std::error_code ignored;
  if (!before.empty()) std::filesystem::remove(before, ignored);
  before = folder.path() / name;
  std::ofstream file(before, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes), static_cast<std::streamsize>(size));
  return before;
}

void check_message(std::string_view message) {
  constexpr std::size_t kMost = 4096;
  const bool good =
      !message.empty() && message.size() <= kMost && message.find('\n') == std::string_view::npos;
  if (good) return;
  std::fprintf(stderr, "a message is empty, longer than a line, or has several lines: '%.*s'\n",
               static_cast<int>(message.size()), message.data());
  std::abort();
}

}  // namespace nav::fuzz
