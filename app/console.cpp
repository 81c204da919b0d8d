// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/console.hpp"

#include <algorithm>
#include <cstdio>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "nav/stopwatch.hpp"

namespace nav::app {
namespace {

spdlog::logger& logger() {
  static const auto instance = [] {
    auto made = std::make_shared<spdlog::logger>(
        "sonde", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
    made->set_pattern("sonde: %^%l%$: %v");
    made->set_level(spdlog::level::info);
    return made;
  }();
  return *instance;
}

std::string without_numbers(std::string_view text) {
  std::string plain;
  for (const char c : text) {
    const bool digit = c >= '0' && c <= '9';
    if (!digit) plain += c;
    if (digit && (plain.empty() || plain.back() != '#')) plain += '#';
  }
  return plain;
}

}  // namespace

std::string without_controls(std::string_view text) {
  std::string clean(text);
  for (char& c : clean) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return clean;
}

Console::Console(bool verbose)
    : verbose_(verbose), terminal_(isatty(STDERR_FILENO) == 1), begun_{} {}

void Console::report(Severity severity, std::string_view source, std::string_view message) {
  constexpr std::size_t kMostAlike = 5;
  constexpr std::size_t kMostKinds = 4096;
  bool is_new = false;
  bool last = false;
  {
    const std::lock_guard lock(mutex_);
    std::string alike = std::string(source) + ": " + without_numbers(message);
    const bool full = alike_.size() >= kMostKinds && !alike_.contains(alike);
    std::vector<std::string> none;
    std::vector<std::string>& shown = full ? none : alike_[std::move(alike)];
    const bool said = std::ranges::count(shown, message) > 0;
    is_new = !said && shown.size() < kMostAlike;
    if (is_new) shown.emplace_back(message);
    last = is_new && shown.size() == kMostAlike;
    collected_.report(severity, source, said || is_new ? message : shown.back());
  }
  if (!is_new) return;  // Counted, not repeated.
  if (severity == Severity::kInfo && !verbose_) return;
  const auto level = severity == Severity::kError     ? spdlog::level::err
                     : severity == Severity::kWarning ? spdlog::level::warn
                                                      : spdlog::level::info;
  if (terminal_ && !stage_.empty()) std::fputs("\r\033[K", stderr);
  logger().log(level, "{}: {}{}", without_controls(source), without_controls(message),
               last ? " (more messages like this are only counted)" : "");
}

void Console::begin(const std::string& stage) {
  if (!stage_.empty()) end();
  stage_ = stage;
  drawn_percent_ = -1;
  begun_ = std::chrono::steady_clock::now();
  draw(0);
}

void Console::progress(double fraction) { draw(std::clamp(fraction, 0.0, 1.0)); }

void Console::end(const std::string& outcome) {
  if (stage_.empty()) return;
  const double seconds = seconds_since(begun_);
  std::fprintf(stderr, "%s%s: %s (%.1f s)\n", terminal_ ? "\r\033[K" : "", stage_.c_str(),
               without_controls(outcome).c_str(), seconds);
  stage_.clear();
}

void Console::say(const std::string& line) {
  if (!stage_.empty()) end();
  std::fprintf(stderr, "%s\n", without_controls(line).c_str());
}

void Console::draw(double fraction) {
  if (!terminal_ || stage_.empty()) return;
  const int percent = static_cast<int>(fraction * 100);
  if (percent == drawn_percent_) return;
  drawn_percent_ = percent;
  constexpr int kWidth = 30;
  std::string bar(kWidth, '-');
  std::fill_n(bar.begin(), percent * kWidth / 100, '#');
  std::fprintf(stderr, "\r\033[K[%s] %3d %% %s", bar.c_str(), percent, stage_.c_str());
  std::fflush(stderr);
}

}  // namespace nav::app
