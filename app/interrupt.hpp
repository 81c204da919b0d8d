// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csignal>

namespace nav::app {

/// While one lives, the first SIGINT (Ctrl-C) asks for an orderly end instead of killing the
/// program; the next one kills it. What was before comes back with its end. One at a time; main
/// thread only.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  /// Whether the user asked for the end since.
  [[nodiscard]] bool asked() const;

 private:
  struct sigaction before_ {};
};

}  // namespace nav::app
