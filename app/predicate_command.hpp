// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "app/session_config.hpp"

namespace nav::app {

/// Options of 'sonde predicates', bound to a configuration that outlives the verb.
void add_predicate_options(CLI::App& verb, SessionConfig& config);

}  // namespace nav::app
