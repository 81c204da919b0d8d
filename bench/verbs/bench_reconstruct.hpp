// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "bench/reconstruction.hpp"
#include "io/json.hpp"
#include "nav/result.hpp"

namespace nav::bench {

struct BenchReconstructOptions {
  bool quick = false;              ///< Few and small images: seconds.
  int threads = 0;                 ///< 0: all cores.
  std::vector<std::string> parts;  ///< rates, backward, errors; empty: all.
  std::optional<std::string> json;
};

/// Rates of the methods of reconstruction, and their errors against simulated images. JSON keys are
/// in docs/json.md.
Result<void> run_bench_reconstruct(const BenchReconstructOptions& options, app::Console& console);

/// `images`, `rates`, `backward` and `errors`, as docs/json.md says.
io::Json json_of(const ReconstructionBenchReport& report);

}  // namespace nav::bench
