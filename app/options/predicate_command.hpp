// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "app/options/session_config.hpp"

namespace nav::app {

/// Options of 'sonde predicates', bound to a configuration that outlives the verb.
void add_predicate_options(CLI::App& verb, SessionConfig& config);

/// Of the ultrasound volume alone: labels, stored values, scan lines. options outlives the verb.
void add_ultrasound_options(CLI::App& verb, PredicateOptions& options);

/// What changes a set-up: opacity, features, and by options of these names bars of its histogram.
/// options outlives the verb.
void add_set_up_edits(CLI::App& verb, PredicateOptions& options, const std::string& importance,
                      const std::string& colour);

}  // namespace nav::app
