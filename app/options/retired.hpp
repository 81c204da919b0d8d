// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace CLI {
class App;
}  // namespace CLI

namespace nav::app {

/// Warns on standard error that an option, or a key of a session file, has no effect any more.
/// \p why: the end of the sentence.
void warn_retired(const std::string& name, const std::string& why);

/// Adds an option of earlier versions to a verb. It takes one value, warns that it is ignored, and
/// is not listed by --help. It stays for one version. \p why: see warn_retired().
void add_retired_option(CLI::App& verb, const std::string& option, const std::string& why);

/// The reason for --adaptive-error and its key.
inline constexpr const char* kNoAdaptiveStep = "the fixed step was faster at the same error";

}  // namespace nav::app
