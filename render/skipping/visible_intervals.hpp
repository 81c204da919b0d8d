// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "render/transfer/transfer_table.hpp"

namespace nav::render {

/// Visible entries of a table that lie side by side. A range of whole HU, widened as in
/// TransferTable::visible(), shows some of them if it reaches up to least_high and down to
/// greatest_low.
struct VisibleInterval {
  std::int16_t least_high;
  std::int16_t greatest_low;
};

/// All intervals of a table, in ascending order.
std::vector<VisibleInterval> visible_intervals(const TransferTable& table);

}  // namespace nav::render
