// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options/session_config.hpp"
#include "app/options/session_section.hpp"

namespace nav::app {

/// The section look of a session file, unknown keys refused.
void read_look(Section& section, const std::string& file, std::optional<Error>& error,
               SessionConfig::Look& look);
toml::table look_to_toml(const SessionConfig::Look& look);

}  // namespace nav::app
