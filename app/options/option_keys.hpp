// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <span>

#include "nav/result.hpp"

namespace nav::app {

/// A key of the session file and an option that sets it.
struct OptionOfKey {
  const char* key;
  const char* option;
};
/// Of the keys that validate() checks; an option may set more than one, a key have more than one.
std::span<const OptionOfKey> options_of_keys();

/// What validate() says of a session's key, as the user gave it: where an option of the verb set
/// that key, "--width (output.width_px): expected …, found …". All else is passed on as it is.
Result<void> as_given(const CLI::App& verb, Result<void> checked);

}  // namespace nav::app
