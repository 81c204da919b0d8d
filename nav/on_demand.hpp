// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <stdexcept>

#include "nav/result.hpp"

namespace nav {

/// A table of functions in a shared library that is loaded at the first call, for a part of the
/// program that only some commands need. The library exports a function without arguments, \p name,
/// that returns the table. The library stays loaded. Thread-safe. Returns kUnavailable with the
/// path when the library or the function is not there.
Result<const void*> functions_on_demand(const std::filesystem::path& library, const char* name);

/// Thrown where a part is missing and no error can be returned; the command ends with its message.
class PartMissing : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Path of a library of this program: in the folder of the program, or in \p installed, which is
/// relative to that folder.
std::filesystem::path library_of_program(const std::filesystem::path& file,
                                         const std::filesystem::path& installed);

}  // namespace nav
