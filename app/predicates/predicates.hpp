// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/console.hpp"
#include "app/options/session_config.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// Writes one image that compares two renderings of a volume: the standard rendering, by a grey
/// transfer function of the same opacities, and the rendering by predicates with the predicate
/// histogram below. With scribbles the image has the slices with their strokes and the renderings
/// before and after, each with its histogram. Engine, threads, size of each part and step come from
/// the configuration's section output, everything else from its section predicates. Missing inputs
/// that predicates need (scan lines, labels) are kUsage.
Result<void> run_predicates(const SessionConfig& config, Console& console);

}  // namespace nav::app
