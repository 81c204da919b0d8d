// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "nav/diagnostics.hpp"

namespace nav::app {

/// Messages and progress for the user, on standard error. Warnings and errors of the libraries
/// appear at once, information only when verbose; everything is kept for the report. Of messages
/// that differ only in their numbers, the first five appear; later ones count as the fifth. Colours
/// and moving progress bars appear only on a terminal. Thread-safe, except for progress, which
/// belongs to the main thread.
class Console final : public Diagnostics {
 public:
  explicit Console(bool verbose);
  void report(Severity severity, std::string_view source, std::string_view message) override;
  /// All reported messages; equal ones are folded into one entry with a count.
  [[nodiscard]] std::vector<DiagnosticEntry> entries() const { return collected_.entries(); }

  /// Starts a stage of long work; ends the previous one.
  void begin(const std::string& stage);
  /// Shows the progress of the current stage. fraction: 0 to 1; values outside are clamped.
  void progress(double fraction);
  /// Ends the current stage and prints its outcome and duration.
  void end(const std::string& outcome = "done");
  /// Prints one line for the user, such as the path of the report. Ends the current stage.
  void say(const std::string& line);

 private:
  void draw(double fraction);
  bool verbose_;
  bool terminal_;
  CollectingDiagnostics collected_;
  std::mutex mutex_;
  /// Messages that appeared, by their text without numbers. Guarded by the mutex.
  std::map<std::string, std::vector<std::string>, std::less<>> alike_;
  std::string stage_;
  int drawn_percent_ = -1;
  std::chrono::steady_clock::time_point begun_;
};

/// Shows control characters, and bytes that are no UTF-8, as escape sequences ("\x1b", "\n"). Names
/// come from files, and control characters in them could change the terminal.
std::string without_controls(std::string_view text);

}  // namespace nav::app
