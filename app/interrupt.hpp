// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <csignal>
#include <string>

namespace nav::app {

/// Makes the program say, when SIGINT (Ctrl-C), SIGTERM or SIGHUP ends it, that files under their
/// names are complete. The program is then ended by that signal. Main thread only.
void say_when_stopped();

/// Turns the first SIGINT (Ctrl-C) into a request for an orderly end as long as the object exists.
/// The next SIGINT kills the program. The destructor restores the previous handler. One object at a
/// time; main thread only.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  /// True when SIGINT, SIGTERM or SIGHUP has arrived since the object was constructed.
  [[nodiscard]] bool asked() const;
  /// Which of them, in words: "Ctrl-C".
  [[nodiscard]] std::string by() const;

 private:
  std::array<struct sigaction, 3> before_{};
};

}  // namespace nav::app
