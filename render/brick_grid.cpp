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
void add_row(const std::int16_t* row, int voxels, int edge, std::size_t first, BrickGrid& grid) {
  for (int bx = 0; bx < grid.count.x(); ++bx) {
    std::int16_t low = grid.low[first + size_of(bx)];
    std::int16_t high = grid.high[first + size_of(bx)];
    // Plain minima, which the compiler turns into vector instructions; minmax_element branches.
    const int end = std::min((bx + 1) * edge + 1, voxels);
    for (int i = bx * edge; i < end; ++i) {
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

/// Ranges of cubes of so many voxels along an edge.
BrickGrid make_ranges(const Volume& volume, int edge, int threads) {
  const auto& size = volume.grid().size;
  BrickGrid grid;
  for (int axis = 0; axis < 3; ++axis) {
    grid.count(axis) = (size[size_of(axis)] - 1) / edge + 1;
  }
  const std::size_t total = size_of(grid.count.prod());
  grid.low.assign(total, std::numeric_limits<std::int16_t>::max());
  grid.high.assign(total, std::numeric_limits<std::int16_t>::min());
  for_each_index(grid.count.z(), threads, [&](int bz) {
    const int k_end = std::min((bz + 1) * edge + 1, size[2]);
    for (int k = bz * edge; k < k_end; ++k) {
      for (int by = 0; by < grid.count.y(); ++by) {
        const std::size_t first = size_of((bz * grid.count.y() + by) * grid.count.x());
        const int j_end = std::min((by + 1) * edge + 1, size[1]);
        for (int j = by * edge; j < j_end; ++j) {
          const std::size_t row = size_of(k) * size_of(size[1]) + size_of(j);
          add_row(volume.hu().data() + row * size_of(size[0]), size[0], edge, first, grid);
        }
      }
    }
  });
  return grid;
}

/// Whether ranges of HU may show something.
class Visibility {
 public:
  explicit Visibility(const TransferTable& table)
      : before_(visible_before(table)), entries_(table) {
    const int count = before_.back();
    const auto first = std::upper_bound(before_.begin(), before_.end(), 0) - before_.begin() - 1;
    const auto last = std::lower_bound(before_.begin(), before_.end(), count) - before_.begin() - 1;
    one_interval_ = count > 0 && last - first + 1 == count;
    if (!one_interval_) return;
    const int first_hu = static_cast<int>(table.first_hu());
    least_high_ = clamped(first == 0 ? kLeast : static_cast<int>(first) + first_hu - 1);
    const bool to_end = last == table.size() - 1;
    greatest_low_ = clamped(to_end ? kGreatest : static_cast<int>(last) + first_hu + 1);
  }

  /// shows: for each of the ranges [from, to), 1 or 0, from its first on.
  void of(const BrickGrid& ranges, std::size_t from, std::size_t to, std::uint8_t* shows) const {
    const std::int16_t* low = ranges.low.data();
    const std::int16_t* high = ranges.high.data();
    if (one_interval_) {  // Most transfer functions; the compiler makes vector instructions of it.
      for (std::size_t b = from; b < to; ++b) {
        const bool visible = (high[b] >= least_high_) & (low[b] <= greatest_low_);
        shows[b - from] = static_cast<std::uint8_t>(visible);
      }
      return;
    }
    for (std::size_t b = from; b < to; ++b) {
      const bool visible =
          before_[size_of(entries_.to(high[b]) + 1)] > before_[size_of(entries_.from(low[b]))];
      shows[b - from] = static_cast<std::uint8_t>(visible);
    }
  }

 private:
  static constexpr int kLeast = std::numeric_limits<std::int16_t>::min();
  static constexpr int kGreatest = std::numeric_limits<std::int16_t>::max();
  static std::int16_t clamped(int hu) {
    return static_cast<std::int16_t>(std::clamp(hu, kLeast, kGreatest));
  }

  std::vector<int> before_;
  Entries entries_;
  bool one_interval_ = false;      ///< All visible entries lie side by side.
  std::int16_t least_high_ = 0;    ///< HU that a range must reach up to,
  std::int16_t greatest_low_ = 0;  ///< and down to.
};

/// Adds bits of visible_parts() to a row of bricks: those of a row of parts, bit and bit + 1.
void add_parts(const std::uint8_t* shows, int parts, unsigned bit, std::uint8_t* bricks) {
  const int pairs = parts / 2;
  for (int x = 0; x < pairs; ++x) {
    const unsigned two = shows[2 * x] | static_cast<unsigned>(shows[2 * x + 1]) << 1;
    bricks[x] = static_cast<std::uint8_t>(bricks[x] | two << bit);
  }
  if (parts % 2 != 0) {  // No sample lies in the other part of the last brick.
    bricks[pairs] =
        static_cast<std::uint8_t>(bricks[pairs] | static_cast<unsigned>(shows[parts - 1]) << bit);
  }
}

}  // namespace

BrickGrid make_brick_grid(const Volume& volume, int threads) {
  return make_ranges(volume, kBrickVoxels, threads);
}

BrickGrid make_part_grid(const Volume& volume, int threads) {
  return make_ranges(volume, kPartVoxels, threads);
}

BrickDistances brick_distances(const BrickGrid& bricks, const TransferTable& table, int threads) {
  BrickDistances out;
  out.distance.resize(bricks.low.size());
  const Visibility visibility(table);
  const int slice = bricks.count.x() * bricks.count.y();
  std::vector<std::size_t> occupied(size_of(bricks.count.z()));
  for_each_index(bricks.count.z(), threads, [&](int z) {
    const std::size_t end = size_of((z + 1) * slice);
    visibility.of(bricks, size_of(z * slice), end, out.distance.data() + z * slice);
    std::size_t count = 0;
    for (std::size_t b = size_of(z * slice); b < end; ++b) {
      count += out.distance[b];
      out.distance[b] = static_cast<std::uint8_t>(out.distance[b] - 1);  // 1 to 0, 0 to 255.
    }
    occupied[size_of(z)] = count;
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

std::vector<std::uint8_t> visible_parts(const BrickGrid& parts, const BrickGrid& bricks,
                                        const BrickDistances& distances, const TransferTable& table,
                                        int threads) {
  std::vector<std::uint8_t> out(bricks.low.size());
  std::vector<std::uint8_t> shows(parts.low.size());
  const Visibility visibility(table);
  const std::size_t slice = size_of(parts.count.x() * parts.count.y());
  for_each_index(parts.count.z(), threads, [&](int k) {
    visibility.of(parts, size_of(k) * slice, size_of(k + 1) * slice,
                  shows.data() + size_of(k) * slice);
  });
  for_each_index(bricks.count.z(), threads, [&](int z) {
    for (int y = 0; y < bricks.count.y(); ++y) {
      const std::size_t first = size_of((z * bricks.count.y() + y) * bricks.count.x());
      std::uint8_t* row = out.data() + first;
      for (unsigned bit = 0; bit < 8; bit += 2) {
        const int j = 2 * y + static_cast<int>(bit >> 1 & 1);
        const int k = 2 * z + static_cast<int>(bit >> 2);
        if (j >= parts.count.y() || k >= parts.count.z()) continue;
        const std::size_t at = size_of((k * parts.count.y() + j) * parts.count.x());
        add_parts(shows.data() + at, parts.count.x(), bit, row);
      }
      for (int x = 0; x < bricks.count.x(); ++x) {
        const bool empty = distances.distance[first + size_of(x)] != 0;
        row[x] = static_cast<std::uint8_t>(row[x] | (empty ? 0xFF : 0));
      }
    }
  });
  return out;
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
