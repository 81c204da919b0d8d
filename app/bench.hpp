// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/console.hpp"
#include "nav/result.hpp"

namespace nav::app {

struct BenchRenderOptions {
  std::filesystem::path ct;  ///< Empty: the simulated patient.
  std::string scene;         ///< Only this scene; empty: all.
  bool quick = false;        ///< Small pictures, few steps: to see that it runs.
  int width = 800;           ///< Of the timed pictures, pixels, [16, 8192].
  int height = 600;          ///< Of the timed pictures, pixels, [16, 8192].
  std::optional<std::string> json;
};

/// Run time against error of Sonde's engines beside VTK's volume mappers, in one run, and the
/// agreement of the engines with the reference on the demo's scene. Prints tables; JSON keys are in
/// docs/json.md.
Result<void> run_bench_render(const BenchRenderOptions& options, Console& console);

}  // namespace nav::app
