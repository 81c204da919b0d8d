// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "render/engine.hpp"

namespace nav::app {

/// Creates the engine with that name: "cpu", "gl" or "reference". Returns kUsage for other names
/// and kUnavailable when the machine lacks what the engine needs. threads: 0 for all cores.
Result<std::unique_ptr<render::Engine>> make_engine(const std::string& name, int threads,
                                                    Diagnostics& diagnostics);

}  // namespace nav::app
