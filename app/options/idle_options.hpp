// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "app/options/session_config.hpp"
#include "app/verbs/derive.hpp"
#include "app/verbs/replay.hpp"
#include "app/verbs/simulate/simulate.hpp"
#include "app/verbs/slices.hpp"

namespace nav::app {

/// Each refuses, by name, the first option of a verb that was given and that nothing would come of,
/// because what it acts on is not there or something else replaces it. What a session file says
/// counts as there, but its own keys are not refused: a resolved one holds all of them. kUsage.
Result<void> refuse_idle_of_demo(const CLI::App& verb, const SessionConfig& config);
Result<void> refuse_idle_of_replay(const CLI::App& verb, const SessionConfig& config);
Result<void> refuse_idle_of_register(const CLI::App& verb, const SessionConfig& config,
                                     const RegisterOptions& options);
Result<void> refuse_idle_of_predicates(const CLI::App& verb, const PredicateOptions& options);
Result<void> refuse_idle_of_slices(const CLI::App& verb, const SessionConfig& config,
                                   const SlicesOptions& options);
Result<void> refuse_idle_of_derive(const CLI::App& verb, const DeriveOptions& options);
Result<void> refuse_idle_of_simulate(const CLI::App& verb, const SimulateOptions& options);

}  // namespace nav::app
