// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "render/engine.hpp"

namespace nav::app {

/// "cpu", "gl" or "reference"; kUsage for other names, kUnavailable where the machine lacks what
/// the engine needs.
Result<std::unique_ptr<render::Engine>> make_engine(const std::string& name, int threads,
                                                    Diagnostics& diagnostics);

}  // namespace nav::app
