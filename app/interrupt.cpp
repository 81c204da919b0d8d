// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/interrupt.hpp"

#include <cstddef>
#include <string>
#include <string_view>
#include <unistd.h>

namespace nav::app {
namespace {

volatile std::sig_atomic_t interrupted = 0;  ///< Number of the signal.
/// Ctrl-C, the end of a service or of a batch job, and a terminal that was closed.
constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};

/// Words for a signal. A signal handler may call it.
constexpr std::string_view words_of_signal(int signal) {
  if (signal == SIGTERM) return "the signal SIGTERM";
  if (signal == SIGHUP) return "the end of its terminal (SIGHUP)";
  return "Ctrl-C";
}

void say(std::string_view text) {
  [[maybe_unused]] const auto done = ::write(STDERR_FILENO, text.data(), text.size());
}

}  // namespace

void say_when_stopped() {
  struct sigaction action {};
  // Only functions that a signal handler may call (POSIX.1-2017, 2.4.3).
  action.sa_handler = [](int signal) {
    say("\nsonde: stopped by ");
    say(words_of_signal(signal));
    say(": files that have their final names are complete; others, and the report of this run, "
        "were "
        "not written\n");
    ::raise(signal);
  };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : kSignals) {
    struct sigaction before {};
    // A program that was started to ignore a signal (nohup) goes on ignoring it.
    if (::sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_IGN) continue;
    ::sigaction(signal, &action, nullptr);
  }
}

Interrupt::Interrupt() {
  interrupted = 0;
  struct sigaction action {};
  action.sa_handler = [](int signal) { interrupted = signal; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &action, &before_[i]);
}

Interrupt::~Interrupt() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &before_[i], nullptr);
}

bool Interrupt::asked() const { return interrupted != 0; }

std::string Interrupt::by() const { return std::string(words_of_signal(interrupted)); }

}  // namespace nav::app
