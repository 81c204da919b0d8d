// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl_bricks.hpp"

#include <algorithm>
#include <tbb/parallel_for.h>

namespace nav::render {
namespace {

/// Least and greatest voxel of brick (bi, bj, bk).
std::pair<std::int16_t, std::int16_t> range_of(const Volume& volume, int bi, int bj, int bk) {
  const auto& size = volume.grid().size;
  const auto end = [&](int b, std::size_t axis) {
    return std::min((b + 1) * kGlBrickVoxels, size[axis] - 1);
  };
  const auto row_length = static_cast<std::ptrdiff_t>(end(bi, 0) - bi * kGlBrickVoxels + 1);
  std::int16_t low = volume.at(bi * kGlBrickVoxels, bj * kGlBrickVoxels, bk * kGlBrickVoxels);
  std::int16_t high = low;
  for (int k = bk * kGlBrickVoxels; k <= end(bk, 2); ++k) {
    for (int j = bj * kGlBrickVoxels; j <= end(bj, 1); ++j) {
      const std::int16_t* row = volume.hu().data() +
                                (static_cast<std::ptrdiff_t>(k) * size[1] + j) * size[0] +
                                bi * kGlBrickVoxels;
      for (std::ptrdiff_t i = 0; i < row_length; ++i) {
        low = std::min(low, row[i]);
        high = std::max(high, row[i]);
      }
    }
  }
  return {low, high};
}

/// One raster scan of the two-pass chamfer, exact for the chessboard metric: each brick takes the
/// least of its neighbours already visited, plus one.
void scan(std::vector<std::uint8_t>& distance, const Eigen::Vector3i& n, int sign) {
  const auto index = [&](int i, int j, int k) {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(n.y()) +
            static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(n.x()) +
           static_cast<std::size_t>(i);
  };
  const int total = n.prod();
  for (int step = 0; step < total; ++step) {
    const int at = sign > 0 ? step : total - 1 - step;
    const int i = at % n.x();
    const int j = at / n.x() % n.y();
    const int k = at / n.x() / n.y();
    int best = distance[static_cast<std::size_t>(at)];
    for (int neighbour = 0; neighbour < 13; ++neighbour) {  // The 13 before (0, 0, 0) of 27.
      const int x = i + sign * (neighbour % 3 - 1);
      const int y = j + sign * (neighbour / 3 % 3 - 1);
      const int z = k + sign * (neighbour / 9 - 1);
      if (x < 0 || y < 0 || z < 0 || x >= n.x() || y >= n.y() || z >= n.z()) continue;
      best = std::min(best, distance[index(x, y, z)] + 1);
    }
    distance[static_cast<std::size_t>(at)] = static_cast<std::uint8_t>(best);
  }
}

}  // namespace

GlBrickRanges gl_brick_ranges(const Volume& volume) {
  GlBrickRanges ranges;
  for (int axis = 0; axis < 3; ++axis) {
    const int cells = volume.grid().size[static_cast<std::size_t>(axis)] - 1;
    ranges.count(axis) = std::max(1, (cells + kGlBrickVoxels - 1) / kGlBrickVoxels);
  }
  const auto total = static_cast<std::size_t>(ranges.count.prod());
  ranges.low.resize(total);
  ranges.high.resize(total);
  tbb::parallel_for(0, ranges.count.z(), [&](int bk) {
    for (int bj = 0; bj < ranges.count.y(); ++bj) {
      for (int bi = 0; bi < ranges.count.x(); ++bi) {
        const auto at =
            static_cast<std::size_t>((bk * ranges.count.y() + bj) * ranges.count.x() + bi);
        std::tie(ranges.low[at], ranges.high[at]) = range_of(volume, bi, bj, bk);
      }
    }
  });
  return ranges;
}

std::vector<std::uint8_t> gl_brick_distances(
    const GlBrickRanges& ranges, const std::function<bool(std::int16_t, std::int16_t)>& occupied) {
  std::vector<std::uint8_t> distance(ranges.low.size());
  for (std::size_t b = 0; b < distance.size(); ++b) {
    distance[b] = occupied(ranges.low[b], ranges.high[b]) ? 0 : 255;
  }
  scan(distance, ranges.count, 1);
  scan(distance, ranges.count, -1);
  return distance;
}

}  // namespace nav::render
