// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <csignal>

namespace nav::app {

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

 private:
  std::array<struct sigaction, 3> before_{};
};

}  // namespace nav::app
