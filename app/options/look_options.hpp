// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "app/options/session_config.hpp"

namespace nav::app {

/// Options of a verb that say how the picture looks, bound to a look that outlives the verb.
void add_look_options(CLI::App& verb, SessionConfig::Look& look);

/// Those that say how it is sampled, and --cutaway-mesh.
void add_quality_options(CLI::App& verb, SessionConfig& config);

/// Those of the grey window of the CT's flat pictures.
void add_window_options(CLI::App& verb, SessionConfig::View& view);

}  // namespace nav::app
