// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "bench/verbs/bench.hpp"
#include "bench/verbs/bench_derived.hpp"
#include "bench/verbs/bench_registration.hpp"

namespace nav::bench {

/// Each rejects, by name, the first option of a verb that was given and that would have no effect,
/// because what it acts on is absent or because another option replaces it. kUsage.
Result<void> reject_idle_of_bench(const CLI::App& verb, const BenchRenderOptions& options);
Result<void> reject_idle_of_bench(const CLI::App& verb, const BenchPredicatesOptions& options);
Result<void> reject_idle_of_bench(const CLI::App& verb, const BenchRegistrationOptions& options);
Result<void> reject_idle_of_bench(const CLI::App& verb, const BenchDerivedOptions& options);

}  // namespace nav::bench
