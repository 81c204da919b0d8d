// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/show_in_window.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <sys/mman.h>
#include <unistd.h>

#include "app/verbs/other_program.hpp"

namespace nav::app {
namespace {

/// Path of a file in memory that holds a text. It lives as long as this process and the program
/// that replaces it.
Result<std::string> file_in_memory(const std::string& text) {
  const int file = ::memfd_create("session.toml", 0);
  const auto failed = [] {
    return Error{ErrorCode::kIo, "session file in memory: " + std::string(std::strerror(errno))};
  };
  if (file < 0) return failed();
  for (std::size_t done = 0; done < text.size();) {
    const auto written = ::write(file, text.data() + done, text.size() - done);
    if (written < 0 && errno != EINTR) return failed();
    if (written > 0) done += static_cast<std::size_t>(written);
  }
  return "/proc/self/fd/" + std::to_string(file);
}

}  // namespace

Result<void> show_in_window(const SessionConfig& config, const std::optional<std::string>& json) {
  SessionConfig shown = config;
  shown.output.window = false;
  const auto text = to_toml(shown);
  if (!text) return text.error();
  const auto path = file_in_memory(*text);
  if (!path) return path.error();
  OtherProgram program{kWindowProgram, kHowToGetTheWindow, {"sonde window", *path, "--once"}};
  const auto add = [&](const char* option, const std::string& value) {
    program.words.insert(program.words.end(), {option, value});
  };
  if (json) add("--json", *json);
  // The window chooses between the others.
  if (config.output.engine == "gl") add("--engine", config.output.engine);
  if (config.output.seconds > 0) {
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%.17g", config.output.seconds);
    add("--seconds", seconds);
  }
  if (!config.output.record.empty()) add("--record", config.output.record.string());
  return run_other_program(program);
}

}  // namespace nav::app
