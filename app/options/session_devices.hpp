// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options/session_section.hpp"
#include "app/options/settings.hpp"

namespace nav::app {

/// Reads and writes the devices of a live session: a list of tables in its file.
void read_devices(Section& root, const char* key, Settings& settings);
void write_devices(KeyWriter& writer, const char* key, const Settings& settings);

}  // namespace nav::app
