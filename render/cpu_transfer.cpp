// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_transfer.hpp"

#include <algorithm>

namespace nav::render {

std::vector<TableEntry> march_entries(const TransferTable& table) {
  std::vector<TableEntry> entries(static_cast<std::size_t>(table.size()));
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const float* value = table.rgbat().data() + 4 * i;
    std::copy_n(value, 4, entries[i].value);
    if (i == 0) continue;
    for (std::size_t c = 0; c < 4; ++c)
      entries[i - 1].to_next[c] = value[c] - entries[i - 1].value[c];
  }
  std::fill_n(entries.back().to_next, 4, 0.0F);
  return entries;
}

}  // namespace nav::render
