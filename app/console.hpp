// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "nav/diagnostics.hpp"

namespace nav::app {

/// What the user sees while the program works, on standard error: warnings and errors of the
/// libraries at once, information only when verbose; everything is kept for the report. Colour and
/// moving progress bars only on a terminal. Thread-safe except progress, which belongs to main.
class Console final : public Diagnostics {
 public:
  explicit Console(bool verbose);
  void report(Severity severity, std::string_view source, std::string_view message) override;
  /// Everything that was reported, folded.
  [[nodiscard]] std::vector<DiagnosticEntry> entries() const { return collected_.entries(); }

  /// Starts a stage of long work; ends the one before.
  void begin(const std::string& stage);
  /// fraction in [0, 1] of the current stage.
  void progress(double fraction);
  /// Ends the current stage with a word on its outcome and the time it took.
  void end(const std::string& outcome = "done");
  /// One plain line for the user, such as where the report lies.
  void say(const std::string& line);

 private:
  void draw(double fraction);
  bool verbose_;
  bool terminal_;
  CollectingDiagnostics collected_;
  std::string stage_;
  int drawn_percent_ = -1;
  std::chrono::steady_clock::time_point begun_;
};

/// A text for a terminal: names come from files, and what steers one is replaced by spaces.
std::string without_controls(std::string_view text);

}  // namespace nav::app
