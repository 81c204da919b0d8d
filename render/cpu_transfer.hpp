// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/cpu_march.hpp"
#include "render/transfer_table.hpp"

namespace nav::render {

/// A table with one entry per HU, laid out for the march.
std::vector<TableEntry> march_entries(const TransferTable& table);

}  // namespace nav::render
