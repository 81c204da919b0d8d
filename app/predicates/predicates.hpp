// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/console.hpp"
#include "app/options/session_config.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// Comparison mode: one picture with the standard rendering of a volume, by a grey transfer
/// function of the same opacities, beside its rendering by predicates, and the predicate histogram
/// below. With scribbles: the slices with their strokes, the rendering before and the one after,
/// each with its histogram. Engine, threads, size of each part and step come from the
/// configuration's section output, everything else from its section predicates. What options ask
/// for and files do not hold (scan lines, labels) is kUsage.
Result<void> run_predicates(const SessionConfig& config, Console& console);

}  // namespace nav::app
