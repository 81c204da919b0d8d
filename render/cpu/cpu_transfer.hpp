// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/cpu/cpu_march.hpp"
#include "render/transfer/transfer_table.hpp"

namespace nav::render {

/// A table in the layout of the march: one entry per HU, row after row.
std::vector<TableEntry> march_entries(const TransferTable& table);

/// The integrals of a table's first row over the values of a volume.
struct MarchIntegrals {
  std::vector<IntegralEntry> entries;  ///< table.size() + 1 entries; see MarchInputs::integrals.
  float quantum = 1;                   ///< HU/mm.
};
/// Makes the integrals for values in [low_hu, high_hu]. The table's own integrals end with the
/// table. Here the end values continue to those limits, and no integral leaves the range of int32.
MarchIntegrals march_integrals(const TransferTable& table, double low_hu, double high_hu);

}  // namespace nav::render
