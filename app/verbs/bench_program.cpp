// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/bench_program.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <unistd.h>

namespace nav::app {

std::optional<std::vector<std::string>> bench_words(int argc, const char* const* argv) {
  int verb = 1;
  const auto verbose = [](std::string_view word) {
    return word.starts_with("-v") || word.starts_with("--verbose");
  };
  while (verb < argc && verbose(argv[verb])) ++verb;
  if (verb >= argc) return {};
  const std::string_view name = argv[verb];
  if (name != "bench" && name != "gallery") return {};
  std::vector<std::string> words{name == "bench" ? "sonde bench" : "sonde"};
  for (int i = 1; i < argc; ++i) {
    if (i != verb || name == "gallery") words.emplace_back(argv[i]);
  }
  return words;
}

Error run_bench_program(const std::vector<std::string>& words) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));  // NOLINT
  argv.push_back(nullptr);
  std::error_code none;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", none).parent_path();
  const auto beside = folder / "sonde-bench";
  std::fflush(nullptr);
  ::execv(beside.c_str(), argv.data());
  if (errno == ENOENT) ::execvp("sonde-bench", argv.data());
  const int failed = errno;
  if (failed != ENOENT) {
    return {ErrorCode::kUnavailable,
            "sonde-bench: could not be run: " + std::string(std::strerror(failed))};
  }
  return {ErrorCode::kUnavailable,
          "sonde-bench is not installed: expected it in " + folder.string() +
              " or in the PATH, found none; build it with -DSONDE_BUILD_BENCH=ON"};
}

}  // namespace nav::app
