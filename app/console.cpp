// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/console.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
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

namespace {

/// Number of bytes of the UTF-8 character at the beginning of a text; 0 if there is none, or one
/// that controls a terminal.
std::size_t printable_bytes(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const unsigned first = byte(0);
  if (first < 0x80) return first < 0x20 || first == 0x7f ? 0 : 1;
  if (first < 0xc2 || first > 0xf4) return 0;
  const std::size_t size = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0U) != 0x80) return 0;
  }
  const bool control = first == 0xc2 && byte(1) < 0xa0;  // U+0080 to U+009F.
  return control ? 0 : size;
}

}  // namespace

std::string without_controls(std::string_view text) {
  std::string clean;
  while (!text.empty()) {
    const std::size_t size = printable_bytes(text);
    if (size > 0) {
      clean += text.substr(0, size);
    } else if (text.front() == '\n') {
      clean += "\\n";
    } else {
      char code[8];
      std::snprintf(code, sizeof code, "\\x%02x", static_cast<unsigned char>(text.front()));
      clean += code;
    }
    text.remove_prefix(std::max<std::size_t>(size, 1));
  }
  return clean;
}

std::string for_terminal(std::string_view text) {
  constexpr std::size_t kLongest = 300;
  constexpr std::size_t kBeginning = 100;
  constexpr std::size_t kEnd = 40;
  std::string shown;
  while (!text.empty()) {
    const std::size_t size = std::min(text.find_first_of(" \n"), text.size() - 1) + 1;
    const std::string_view word = text.substr(0, size);
    shown += size <= kLongest ? std::string(word)
                              : std::string(word.substr(0, kBeginning)) + "…" +
                                    std::string(word.substr(size - kEnd));
    text.remove_prefix(size);
  }
  return without_controls(shown);
}

Console::Console(bool verbose)
    : verbose_(verbose), terminal_(isatty(STDERR_FILENO) == 1), begun_{} {}

void Console::take(const DiagnosticEntry& entry) {
  constexpr std::size_t kMostAlike = 5;
  constexpr std::size_t kMostKinds = 4096;
  bool is_new = false;
  bool last = false;
  {
    const std::lock_guard lock(mutex_);
    std::string kind =
        entry.finding ? kind_of(entry) : entry.source + ": " + without_numbers(entry.message);
    const bool full = alike_.size() >= kMostKinds && !alike_.contains(kind);
    Alike none;
    Alike& alike = full ? none : alike_[std::move(kind)];
    const std::size_t most = entry.finding ? 1 : kMostAlike;
    const bool said = std::ranges::count(alike.shown, entry.message) > 0;
    is_new = !said && alike.shown.size() < most;
    if (is_new) alike.shown.push_back(entry.message);
    if (!is_new) ++alike.more;
    alike.of_interest = verbose_ || entry.severity != Severity::kInfo;
    last = is_new && most > 1 && alike.shown.size() == most;
    DiagnosticEntry kept = entry;
    if (!said && !is_new) kept.message = alike.shown.back();
    collected_.take(kept);
  }
  if (!is_new) return;  // Counted, not repeated.
  if (entry.severity == Severity::kInfo && !verbose_) return;
  const auto level = entry.severity == Severity::kError     ? spdlog::level::err
                     : entry.severity == Severity::kWarning ? spdlog::level::warn
                                                            : spdlog::level::info;
  if (terminal_ && !stage_.empty()) std::fputs("\r\033[K", stderr);
  logger().log(level, "{}: {}{}", for_terminal(entry.source), for_terminal(entry.message),
               last ? " (more messages like this are only counted)" : "");
}

void Console::say_suppressed() {
  const std::lock_guard lock(mutex_);
  for (const auto& [kind, alike] : alike_) {
    if (alike.more == 0 || !alike.of_interest) continue;
    std::fprintf(stderr, "sonde: %zu more like this: %s\n", alike.more,
                 for_terminal(alike.shown.back()).c_str());
  }
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
               for_terminal(outcome).c_str(), seconds);
  stage_.clear();
}

void Console::say(const std::string& line) {
  if (!stage_.empty()) end();
  std::fprintf(stderr, "%s\n", for_terminal(line).c_str());
}

namespace {

/// True: a program that runs this one reads the progress, one line for each percent.
bool tells_lines() {
  static const bool tells = [] {
    const char* wanted = std::getenv("SONDE_PROGRESS");
    return wanted != nullptr && std::string_view(wanted) == "lines";
  }();
  return tells;
}

}  // namespace

void Console::draw(double fraction) {
  if (stage_.empty() || (!terminal_ && !tells_lines())) return;
  const int percent = static_cast<int>(fraction * 100);
  if (percent == drawn_percent_) return;
  drawn_percent_ = percent;
  if (!terminal_) {
    std::fprintf(stderr, "progress %d %s\n", percent, stage_.c_str());
    std::fflush(stderr);
    return;
  }
  constexpr int kWidth = 30;
  std::string bar(kWidth, '-');
  std::fill_n(bar.begin(), percent * kWidth / 100, '#');
  std::fprintf(stderr, "\r\033[K[%s] %3d %% %s", bar.c_str(), percent, stage_.c_str());
  std::fflush(stderr);
}

}  // namespace nav::app
