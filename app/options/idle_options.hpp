// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "app/bench/bench.hpp"
#include "app/bench/bench_derived.hpp"
#include "app/bench/bench_registration.hpp"

namespace nav::app {

/// Each refuses, by name, the first option of a verb that was given and that nothing would come of,
/// because what it acts on is not there or something else replaces it. kUsage.
Result<void> refuse_idle_of_bench(const CLI::App& verb, const BenchRenderOptions& options);
Result<void> refuse_idle_of_bench(const CLI::App& verb, const BenchPredicatesOptions& options);
Result<void> refuse_idle_of_bench(const CLI::App& verb, const BenchRegistrationOptions& options);
Result<void> refuse_idle_of_bench(const CLI::App& verb, const BenchDerivedOptions& options);

}  // namespace nav::app
