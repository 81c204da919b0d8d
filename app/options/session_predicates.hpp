// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options/session_section.hpp"
#include "app/options/settings.hpp"

namespace nav::app {

/// predicates.histogram of a session file, a list of tables.
void read_histogram(Section& section, const char* key, Settings& settings);
void write_histogram(KeyWriter& writer, const char* key, const Settings& settings);

/// predicates.set_up: a preset keeps its name; anything else is a file beside the session file.
void read_predicate_set(Section& section, const char* key, Settings& settings);
void write_predicate_set(KeyWriter& writer, const char* key, const Settings& settings);

}  // namespace nav::app
