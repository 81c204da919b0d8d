// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/hounsfield.hpp"

#include <algorithm>

namespace nav {

bool is_hounsfield(const StoredVolume& volume) {
  constexpr std::size_t kHundred = 100;
  constexpr std::size_t kBlock = 1 << 16;
  const auto voxels = volume.values();
  const std::size_t enough = (voxels.size() + kHundred - 1) / kHundred;
  std::size_t below = 0;
  for (std::size_t begin = 0; begin < voxels.size() && below < enough; begin += kBlock) {
    const auto block = voxels.subspan(begin, std::min(kBlock, voxels.size() - begin));
    below += static_cast<std::size_t>(
        std::ranges::count_if(block, [](int v) { return v < kLeastTissueHu; }));
  }
  return below >= enough;
}

}  // namespace nav
