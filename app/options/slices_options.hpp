// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "app/verbs/slices.hpp"

namespace nav::app {

/// Options of `slices` that say which slices and how they look, bound to options that outlive the
/// verb; those of the recording are added before.
void add_slices_options(CLI::App& verb, SessionConfig& config, SlicesOptions& options);

}  // namespace nav::app
