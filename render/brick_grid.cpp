// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/brick_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/parallel.hpp"

namespace nav::render {
namespace {

std::size_t size_of(int n) { return static_cast<std::size_t>(n); }

/// Widens the ranges of a row of bricks, from first on, by a row of voxels.
void add_row(const std::int16_t* row, int voxels, std::size_t first, BrickGrid& grid) {
  for (int bx = 0; bx < grid.count.x(); ++bx) {
    std::int16_t low = grid.low[first + size_of(bx)];
    std::int16_t high = grid.high[first + size_of(bx)];
    // Plain minima, which the compiler turns into vector instructions; minmax_element branches.
    const int end = std::min((bx + 1) * kBrickVoxels + 1, voxels);
    for (int i = bx * kBrickVoxels; i < end; ++i) {
      low = std::min(low, row[i]);
      high = std::max(high, row[i]);
    }
    grid.low[first + size_of(bx)] = low;
    grid.high[first + size_of(bx)] = high;
  }
}

/// Distances after one sweep: from the neighbours already visited when walking in direction
/// step (+1 or -1) through the bricks.
void sweep(const Eigen::Vector3i& n, int step, std::vector<std::uint8_t>& d) {
  const int total = n.prod();
  const auto inside = [&](int x, int y, int z) {
    return x >= 0 && x < n.x() && y >= 0 && y < n.y() && z >= 0 && z < n.z();
  };
  for (int count = 0, at = step > 0 ? 0 : total - 1; count < total; ++count, at += step) {
    const int x = at % n.x();
    const int y = at / n.x() % n.y();
    const int z = at / (n.x() * n.y());
    int best = d[size_of(at)];
    // The 13 neighbours that precede in this direction; the order of the others mirrors them.
    for (int i = 0; i < 13 && best > 0; ++i) {
      const int dx = (i % 3 - 1) * step;
      const int dy = (i / 3 % 3 - 1) * step;
      const int dz = (i / 9 - 1) * step;
      if (!inside(x + dx, y + dy, z + dz)) continue;
      const int neighbour = at + dx + n.x() * (dy + n.y() * dz);
      best = std::min(best, d[size_of(neighbour)] + 1);
    }
    d[size_of(at)] = static_cast<std::uint8_t>(best);
  }
}

}  // namespace

BrickGrid make_brick_grid(const Volume& volume, int threads) {
  const auto& size = volume.grid().size;
  BrickGrid grid;
  for (int axis = 0; axis < 3; ++axis) {
    grid.count(axis) = (size[size_of(axis)] - 1) / kBrickVoxels + 1;
  }
  const std::size_t total = size_of(grid.count.prod());
  grid.low.assign(total, std::numeric_limits<std::int16_t>::max());
  grid.high.assign(total, std::numeric_limits<std::int16_t>::min());
  for_each_index(grid.count.z(), threads, [&](int bz) {
    const int k_end = std::min((bz + 1) * kBrickVoxels + 1, size[2]);
    for (int k = bz * kBrickVoxels; k < k_end; ++k) {
      for (int by = 0; by < grid.count.y(); ++by) {
        const std::size_t first = size_of((bz * grid.count.y() + by) * grid.count.x());
        const int j_end = std::min((by + 1) * kBrickVoxels + 1, size[1]);
        for (int j = by * kBrickVoxels; j < j_end; ++j) {
          const std::size_t row = size_of(k) * size_of(size[1]) + size_of(j);
          add_row(volume.hu().data() + row * size_of(size[0]), size[0], first, grid);
        }
      }
    }
  });
  return grid;
}

BrickDistances brick_distances(const BrickGrid& bricks, const TransferTable& table) {
  BrickDistances out;
  out.distance.resize(bricks.low.size());
  for (std::size_t b = 0; b < out.distance.size(); ++b) {
    const bool occupied = table.visible(bricks.low[b], bricks.high[b]);
    out.distance[b] = occupied ? 0 : 255;
    if (occupied) ++out.occupied;
  }
  // Two sweeps over the 26-neighbourhood give the exact chessboard distance.
  sweep(bricks.count, +1, out.distance);
  sweep(bricks.count, -1, out.distance);
  return out;
}

std::vector<std::uint8_t> brick_importance(const BrickGrid& bricks, const TransferTable& table) {
  std::vector<std::uint8_t> out(bricks.low.size());
  for (std::size_t b = 0; b < out.size(); ++b) {
    const double importance = table.max_importance(bricks.low[b], bricks.high[b]);
    out[b] = static_cast<std::uint8_t>(importance < 1 ? std::ceil(importance * 254) : 255);
  }
  return out;
}

}  // namespace nav::render
