// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options/session_section.hpp"
#include "app/options/settings.hpp"

namespace nav::app {

/// look.nodes and look.importance of a session file, lists of tables.
void read_appearance_nodes(Section& section, const char* key, Settings& settings);
void write_appearance_nodes(KeyWriter& writer, const char* key, const Settings& settings);
void read_appearance_importance(Section& section, const char* key, Settings& settings);
void write_appearance_importance(KeyWriter& writer, const char* key, const Settings& settings);

}  // namespace nav::app
