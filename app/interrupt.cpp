// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/interrupt.hpp"

#include <cstddef>

namespace nav::app {
namespace {

volatile std::sig_atomic_t interrupted = 0;
/// Ctrl-C, the end of a service or of a batch job, and a terminal that was closed.
constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};

}  // namespace

Interrupt::Interrupt() {
  interrupted = 0;
  struct sigaction action {};
  action.sa_handler = [](int) { interrupted = 1; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &action, &before_[i]);
}

Interrupt::~Interrupt() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &before_[i], nullptr);
}

bool Interrupt::asked() const { return interrupted != 0; }

}  // namespace nav::app
