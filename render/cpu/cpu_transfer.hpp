// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/cpu/cpu_march.hpp"
#include "render/transfer/transfer_table.hpp"

namespace nav::render {

/// A table laid out for the march: one entry per HU, row after row.
std::vector<TableEntry> march_entries(const TransferTable& table);

/// The integrals of a table's first row over the values that a volume has.
struct MarchIntegrals {
  std::vector<IntegralEntry> entries;  ///< table.size() + 1, as MarchInputs::integrals.
  float quantum = 1;                   ///< HU/mm.
};
/// Values of the march lie in [low_hu, high_hu]. The table's own integrals end with the table; here
/// its end values are held up to those limits without an integral leaving the range of int32.
MarchIntegrals march_integrals(const TransferTable& table, double low_hu, double high_hu);

}  // namespace nav::render
