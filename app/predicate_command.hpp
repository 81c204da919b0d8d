// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "app/session_config.hpp"

namespace nav::app {

/// Options of 'sonde predicates', bound to a configuration that outlives the verb.
void add_predicate_options(CLI::App& verb, SessionConfig& config);

/// Of the ultrasound volume alone: labels, stored values, scan lines. options outlives the verb.
void add_ultrasound_options(CLI::App& verb, PredicateOptions& options);

}  // namespace nav::app
