// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "app/console.hpp"
#include "nav/result.hpp"

namespace nav::bench {

struct BenchVesselsOptions {
  std::optional<std::string> json;
};

/// Blood that is visible as vessel, and visible vessel that is bone: of the presets with vessels,
/// as they are and fitted to the scan, on the labelled CT angiography (SONDE_DATA_DIR) and on
/// simulated CT in the arterial and portal phase. Reports what is missing.
Result<void> run_bench_vessels(const BenchVesselsOptions& options, app::Console& console);

}  // namespace nav::bench
