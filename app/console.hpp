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
/// appear at once, information only when verbose; everything is kept for the report. Of findings of
/// one subject and key the first appears; of other messages that differ only in their numbers, the
/// first five do, and later ones count as the fifth. Colours and moving progress bars appear only
/// on a terminal. Thread-safe, except for progress, which belongs to the main thread.
class Console final : public Diagnostics {
 public:
  explicit Console(bool verbose);
  void take(const DiagnosticEntry& entry) override;
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
  /// Says how many messages did not appear, one line for each kind. Called at the end of a run.
  void say_suppressed();

 private:
  /// Messages of one kind: those that appeared, and how many more came.
  struct Alike {
    std::vector<std::string> shown;
    std::size_t more = 0;
    bool of_interest = false;  ///< More than information, or information is shown, too.
  };
  void draw(double fraction);
  bool verbose_;
  bool terminal_;
  CollectingDiagnostics collected_;
  std::mutex mutex_;
  /// Key: the kind of a finding, or the text without numbers. Guarded by the mutex.
  std::map<std::string, Alike, std::less<>> alike_;
  std::string stage_;
  int drawn_percent_ = -1;
  std::chrono::steady_clock::time_point begun_;
};

/// Shows control characters, and bytes that are no UTF-8, as escape sequences ("\x1b", "\n"). Names
/// come from files, and control characters in them could change the terminal.
std::string without_controls(std::string_view text);

/// A message for the terminal: without control characters, and with words of more than 300 bytes,
/// which are contents of files, shortened to their beginning and their end.
std::string for_terminal(std::string_view text);

}  // namespace nav::app
