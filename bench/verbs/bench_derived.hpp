// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "app/console.hpp"
#include "bench/derived.hpp"
#include "io/json.hpp"
#include "nav/result.hpp"

namespace nav::bench {

struct BenchDerivedOptions {
  int side = 256;      ///< Side of the timed volume, voxels, [32, 512].
  bool quick = false;  ///< 96 voxels a side, once each.
  int threads = 0;     ///< 0: all cores.
  std::optional<std::string> json;
};

/// Time, memory and error of the features that predicates read, each beside its own double
/// definition and, where ITK was found at build time and has it, ITK's filter on the same voxels.
/// JSON keys are in docs/json.md.
Result<void> run_bench_derived(const BenchDerivedOptions& options, app::Console& console);

/// `side`, `timings` and `errors`, as docs/json.md says.
io::Json json_of(const DerivedBenchReport& report);

}  // namespace nav::bench
