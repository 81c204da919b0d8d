// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/brick_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

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

/// The entries of a table that a range of whole HU touches, as TransferTable::visible() widens it.
class Entries {
 public:
  explicit Entries(const TransferTable& table)
      : first_hu_(static_cast<int>(table.first_hu())), last_(table.size() - 1) {}
  [[nodiscard]] int from(int low_hu) const { return std::clamp(low_hu - first_hu_ - 1, 0, last_); }
  [[nodiscard]] int to(int high_hu) const { return std::clamp(high_hu - first_hu_ + 1, 0, last_); }

 private:
  int first_hu_;
  int last_;
};

/// Number of entries, visible in any row, among the first i.
std::vector<int> visible_before(const TransferTable& table) {
  const std::size_t size = size_of(table.size());
  std::vector<int> before(size + 1);
  for (std::size_t i = 0; i < table.importance().size(); ++i) {
    if (table.rgbat()[4 * i + 3] > 0) before[i % size + 1] = 1;
  }
  std::partial_sum(before.begin(), before.end(), before.begin());
  return before;
}

std::uint8_t importance_byte(float importance) {
  const double exact = importance;
  return static_cast<std::uint8_t>(exact < 1 ? std::ceil(exact * 254) : 255);
}

/// Greatest importance of 2^level entries from i on, level by level.
std::vector<std::vector<std::uint8_t>> importance_levels(const TransferTable& table) {
  const std::size_t size = size_of(table.size());
  std::vector<std::vector<std::uint8_t>> levels(1, std::vector<std::uint8_t>(size));
  for (std::size_t i = 0; i < table.importance().size(); ++i) {
    if (!(table.rgbat()[4 * i + 3] > 0)) continue;
    std::uint8_t& greatest = levels[0][i % size];
    greatest = std::max(greatest, importance_byte(table.importance()[i]));
  }
  for (std::size_t half = 1; 2 * half <= size; half *= 2) {
    const std::vector<std::uint8_t>& below = levels.back();
    std::vector<std::uint8_t> level(size - 2 * half + 1);
    for (std::size_t i = 0; i < level.size(); ++i) level[i] = std::max(below[i], below[i + half]);
    levels.push_back(std::move(level));
  }
  return levels;
}

/// Distance to the nearest 0 of each row along x, from 0 and 255.
void spread_along_x(const Eigen::Vector3i& n, int z, std::vector<std::uint8_t>& d) {
  for (int y = 0; y < n.y(); ++y) {
    std::uint8_t* row = d.data() + size_of((z * n.y() + y) * n.x());
    int near = 255;
    for (int x = 0; x < n.x(); ++x) {
      near = row[x] == 0 ? 0 : std::min(near + 1, 255);
      row[x] = static_cast<std::uint8_t>(near);
    }
    for (int x = n.x() - 1; x >= 0; --x) {
      near = std::min<int>(near + 1, row[x]);
      row[x] = static_cast<std::uint8_t>(near);
    }
  }
}

/// out[i] = min over j of max(|i - j|, in[j]), j along an axis of rows of `width` bytes, `stride`
/// apart: the Chebyshev distance after one more axis.
void spread_rows(const std::uint8_t* in, std::uint8_t* out, int count, int stride, int width) {
  for (int i = 0; i < count; ++i) {
    std::uint8_t* to = out + size_of(i) * size_of(stride);
    std::copy_n(in + size_of(i) * size_of(stride), width, to);
    int most = *std::max_element(to, to + width);
    // Rows beyond the greatest distance so far cannot lower any.
    for (int s = 1; s < most && (i - s >= 0 || i + s < count); ++s) {
      const std::uint8_t* low = in + size_of(std::max(i - s, 0)) * size_of(stride);
      const std::uint8_t* high = in + size_of(std::min(i + s, count - 1)) * size_of(stride);
      // A row taken from the border instead of beyond it is nearer than s: no harm.
      const auto away = static_cast<std::uint8_t>(s);
      std::uint8_t rest = 0;
      for (int x = 0; x < width; ++x) {
        const std::uint8_t there = std::max(away, std::min(low[x], high[x]));
        to[x] = std::min(to[x], there);
        rest = std::max(rest, to[x]);
      }
      most = rest;
    }
  }
}

/// Turns 0 and 255 into the distance to the nearest 0, one axis after the other.
void chebyshev(const Eigen::Vector3i& n, int threads, std::vector<std::uint8_t>& d) {
  std::vector<std::uint8_t> other(d.size());
  const int slice = n.x() * n.y();
  for_each_index(n.z(), threads, [&](int z) {
    spread_along_x(n, z, d);
    spread_rows(d.data() + size_of(z * slice), other.data() + size_of(z * slice), n.y(), n.x(),
                n.x());
  });
  for_each_index(n.y(), threads, [&](int y) {
    spread_rows(other.data() + size_of(y * n.x()), d.data() + size_of(y * n.x()), n.z(), slice,
                n.x());
  });
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

BrickDistances brick_distances(const BrickGrid& bricks, const TransferTable& table, int threads) {
  BrickDistances out;
  out.distance.resize(bricks.low.size());
  const std::vector<int> before = visible_before(table);
  const Entries entries(table);
  const int slice = bricks.count.x() * bricks.count.y();
  std::vector<std::size_t> occupied(size_of(bricks.count.z()));
  for_each_index(bricks.count.z(), threads, [&](int z) {
    const std::size_t end = size_of((z + 1) * slice);
    for (std::size_t b = size_of(z * slice); b < end; ++b) {
      const bool visible = before[size_of(entries.to(bricks.high[b]) + 1)] >
                           before[size_of(entries.from(bricks.low[b]))];
      out.distance[b] = visible ? 0 : 255;
      occupied[size_of(z)] += visible ? 1 : 0;
    }
  });
  out.occupied = std::accumulate(occupied.begin(), occupied.end(), std::size_t{0});
  chebyshev(bricks.count, threads, out.distance);
  return out;
}

std::vector<std::uint8_t> brick_depths(const BrickGrid& bricks, const BrickDistances& distances,
                                       int threads) {
  std::vector<std::uint8_t> depths(bricks.low.size());
  std::transform(distances.distance.begin(),
                 distances.distance.begin() + static_cast<std::ptrdiff_t>(depths.size()),
                 depths.begin(),
                 [](std::uint8_t d) { return static_cast<std::uint8_t>(d == 0 ? 255 : 0); });
  chebyshev(bricks.count, threads, depths);
  return depths;
}

std::vector<std::uint8_t> brick_importance(const BrickGrid& bricks, const TransferTable& table,
                                           int threads) {
  std::vector<std::uint8_t> out(bricks.low.size());
  const auto levels = importance_levels(table);
  const Entries entries(table);
  const int slice = bricks.count.x() * bricks.count.y();
  for_each_index(bricks.count.z(), threads, [&](int z) {
    const std::size_t end = size_of((z + 1) * slice);
    for (std::size_t b = size_of(z * slice); b < end; ++b) {
      const std::size_t from = size_of(entries.from(bricks.low[b]));
      const std::size_t past = size_of(entries.to(bricks.high[b]) + 1);
      const auto level = static_cast<std::size_t>(std::bit_width(past - from) - 1);
      const std::vector<std::uint8_t>& greatest = levels[level];
      out[b] = std::max(greatest[from], greatest[past - (std::size_t{1} << level)]);
    }
  });
  return out;
}

}  // namespace nav::render
