// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options/session_section.hpp"
#include "app/options/settings.hpp"

namespace nav::app {

/// cutaway_objects of a session file, a list of tables.
void read_cutaway_list(Section& root, const char* key, Settings& settings);
void write_cutaway_list(KeyWriter& writer, const char* key, const Settings& settings);

}  // namespace nav::app
