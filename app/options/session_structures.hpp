// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options/session_section.hpp"
#include "app/options/settings.hpp"

namespace nav::app {

/// The list of critical structures of a session file.
void read_structures(Section& root, const char* key, Settings& settings);
void write_structures(KeyWriter& writer, const char* key, const Settings& settings);

}  // namespace nav::app
