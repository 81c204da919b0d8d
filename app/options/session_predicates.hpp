// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options/session_config.hpp"
#include "app/options/session_section.hpp"

namespace nav::app {

/// The section predicates of a session file, unknown keys refused.
void read_predicates(Section& section, const std::string& file, std::optional<Error>& error,
                     PredicateOptions& options);
toml::table predicates_to_toml(const PredicateOptions& options);

}  // namespace nav::app
