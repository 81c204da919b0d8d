// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl/gl_gradients.hpp"

#include <algorithm>
#include <atomic>
#include <limits>

#include "render/parallel.hpp"

namespace nav::render {

std::vector<std::int16_t> neighbour_differences(const StoredVolume& volume) {
  const auto& n = volume.grid().size;
  const std::int16_t* hu = volume.values().data();
  const auto nx = static_cast<std::ptrdiff_t>(n[0]);
  const std::ptrdiff_t nxy = nx * n[1];
  std::vector<std::int16_t> out(4 * volume.grid().voxel_count());
  std::atomic<bool> fits{true};
  for_each_index(n[2], 0, [&](int k) {
    int most = 0;
    const auto difference = [&](const std::int16_t* at, std::ptrdiff_t stride, int i, int count) {
      const int d = at[i + 1 < count ? stride : 0] - at[i > 0 ? -stride : 0];
      most = std::max(most, std::abs(d));
      return static_cast<std::int16_t>(d);
    };
    const std::int16_t* at = hu + k * nxy;
    std::int16_t* to = out.data() + 4 * k * nxy;
    for (int j = 0; j < n[1]; ++j) {
      for (int i = 0; i < n[0]; ++i, ++at, to += 4) {
        to[0] = difference(at, 1, i, n[0]);
        to[1] = difference(at, nx, j, n[1]);
        to[2] = difference(at, nxy, k, n[2]);
      }
    }
    if (most > std::numeric_limits<std::int16_t>::max()) fits = false;
  });
  if (!fits) out.clear();
  return out;
}

}  // namespace nav::render
