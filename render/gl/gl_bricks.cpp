// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl/gl_bricks.hpp"

#include <cmath>

namespace nav::render {
BrickTexels brick_texels(const BrickGrid& bricks, const BrickGrid& parts,
                         const std::vector<std::uint8_t>& hidden, const TransferTable& table) {
  const std::vector<std::uint8_t> shows = visible_parts(parts, bricks, hidden, table);
  const BrickDistances distances = brick_distances(bricks, hidden);
  std::vector<std::uint8_t> texels;
  texels.reserve(4 * distances.distance.size());
  for (std::size_t b = 0; b < distances.distance.size(); ++b) {
    texels.push_back(distances.distance[b]);
    const double importance = table.max_importance(bricks.low[b], bricks.high[b]);
    texels.push_back(importance >= 1 ? 255
                                     : static_cast<std::uint8_t>(std::ceil(254 * importance)));
    texels.push_back(shows[b]);
    texels.push_back(0);
  }
  return {std::move(texels), distances.occupied};
}

std::vector<std::uint16_t> brick_range_texels(const BrickGrid& bricks) {
  std::vector<std::uint16_t> texels;
  texels.reserve(2 * bricks.low.size());
  for (std::size_t b = 0; b < bricks.low.size(); ++b) {
    texels.push_back(static_cast<std::uint16_t>(bricks.low[b] + 32768));
    texels.push_back(static_cast<std::uint16_t>(bricks.high[b] + 32768));
  }
  return texels;
}

}  // namespace nav::render
