// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::app {

/// A program beside this one, to which a verb is handed over.
struct OtherProgram {
  std::string name;                ///< Name of its file: "sonde-bench".
  std::string how_to_get;          ///< "build it with -DSONDE_BUILD_BENCH=ON".
  std::vector<std::string> words;  ///< Its command line, with the name by which it calls itself.
};

/// The program of the window, and how to get it.
inline constexpr const char* kWindowProgram = "sonde-window";
inline constexpr const char* kHowToGetTheWindow =
    "build it with Qt 6 (qt6-base-dev) and -DSONDE_BUILD_WINDOW=ON";

/// The program that does what the command line asks for: sonde-bench for `sonde bench …` and
/// `sonde gallery …`, sonde-window for `sonde window …`; absent for other verbs. sonde-bench calls
/// itself "sonde bench", or "sonde" of "sonde gallery".
std::optional<OtherProgram> other_program(int argc, const char* const* argv);

/// Replaces this process by another program: the one beside this program's file, otherwise the one
/// in the PATH. Returns only if that fails: kUnavailable.
Error run_other_program(const OtherProgram& program);

}  // namespace nav::app
