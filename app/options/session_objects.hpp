// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options/session_config.hpp"
#include "app/options/session_section.hpp"

namespace nav::app {

/// The list [[cutaway_objects]] of a session file, unknown keys and types refused.
void read_cutaway_objects(Section& root, const std::string& file, std::optional<Error>& error,
                          std::vector<CutawayObject>& objects);
toml::array cutaway_objects_to_toml(const std::vector<CutawayObject>& objects);

}  // namespace nav::app
