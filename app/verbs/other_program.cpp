// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/other_program.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <unistd.h>

namespace nav::app {

std::optional<OtherProgram> other_program(int argc, const char* const* argv) {
  int verb = 1;
  const auto verbose = [](std::string_view word) {
    return word.starts_with("-v") || word.starts_with("--verbose");
  };
  while (verb < argc && verbose(argv[verb])) ++verb;
  if (verb >= argc) return {};
  const std::string_view name = argv[verb];
  const bool window = name == "window";
  if (name != "bench" && name != "gallery" && !window) return {};
  OtherProgram program{"sonde-bench", "build it with -DSONDE_BUILD_BENCH=ON", {}};
  if (window) {
    program = {kWindowProgram, kHowToGetTheWindow, {}};
  }
  program.words.emplace_back(name == "gallery" ? "sonde" : "sonde " + std::string(name));
  for (int i = window ? verb : 1; i < argc; ++i) {
    if (i != verb || name == "gallery") program.words.emplace_back(argv[i]);
  }
  return program;
}

Error run_other_program(const OtherProgram& program) {
  std::vector<char*> argv;
  for (const std::string& word : program.words) {
    argv.push_back(const_cast<char*>(word.c_str()));  // NOLINT
  }
  argv.push_back(nullptr);
  std::error_code none;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", none).parent_path();
  const auto beside = folder / program.name;
  std::fflush(nullptr);
  ::execv(beside.c_str(), argv.data());
  if (errno == ENOENT) ::execvp(program.name.c_str(), argv.data());
  const int failed = errno;
  if (failed != ENOENT) {
    return {ErrorCode::kUnavailable,
            program.name + ": could not be run: " + std::string(std::strerror(failed))};
  }
  return {ErrorCode::kUnavailable, program.name + " is not installed: expected it in " +
                                       folder.string() + " or in the PATH, found none; " +
                                       program.how_to_get};
}

}  // namespace nav::app
