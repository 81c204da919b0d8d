// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/program.hpp"

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <system_error>

#include "app/console.hpp"
#include "app/interrupt.hpp"
#include "app/options/exit_code.hpp"
#include "nav/on_demand.hpp"

namespace nav::app {

int print_error(const std::string& program, const Error& error) {
  std::fprintf(stderr, "%s: error: %s\n", program.c_str(), for_terminal(error.message).c_str());
  return exit_code(error);
}

int run_guarded(const std::string& program, const std::function<int()>& body) {
  // A limit on the size of files is then an error of a write, not the end of the program.
  std::signal(SIGXFSZ, SIG_IGN);
  say_when_stopped();
  try {
    return body();
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "%s: error: out of memory: there is too little for what was asked for\n",
                 program.c_str());
    return kExitDevice;
  } catch (const PartMissing& missing) {
    std::fprintf(stderr, "%s: error: %s\n", program.c_str(), missing.what());
    return kExitDevice;
  } catch (const std::system_error& lack) {
    std::fprintf(stderr, "%s: error: %s (too few files, threads or memory, or a missing folder)\n",
                 program.c_str(), without_controls(lack.what()).c_str());
    return kExitDevice;
  } catch (const std::exception& bug) {
    std::string what = bug.what();
    for (char& c : what) c = c == '\n' ? ' ' : c;
    std::fprintf(stderr, "%s: bug: %s\n", program.c_str(), what.c_str());
    return kExitBug;
  }
}

}  // namespace nav::app
