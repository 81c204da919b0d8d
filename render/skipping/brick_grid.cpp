// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/skipping/brick_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <utility>

#include "nav/index.hpp"
#include "render/parallel.hpp"
#include "render/skipping/brick_fold.hpp"
#include "render/skipping/visible_intervals.hpp"

namespace nav::render {
namespace {

/// The entries of a table that a range of whole HU touches, widened as in TransferTable::visible().
class TouchedEntries {
 public:
  explicit TouchedEntries(const TransferTable& table)
      : first_hu_(static_cast<int>(table.first_hu())), last_(table.size() - 1) {}
  [[nodiscard]] int from(int low_hu) const { return std::clamp(low_hu - first_hu_ - 1, 0, last_); }
  [[nodiscard]] int to(int high_hu) const { return std::clamp(high_hu - first_hu_ + 1, 0, last_); }

 private:
  int first_hu_;
  int last_;
};

std::uint8_t importance_byte(float importance) {
  const double exact = importance;
  return static_cast<std::uint8_t>(exact < 1 ? std::ceil(exact * 254) : 255);
}

/// Computes the greatest importance of 2^level entries from i on, level by level.
std::vector<std::vector<std::uint8_t>> importance_levels(const TransferTable& table) {
  const std::size_t size = as_size(table.size());
  std::vector<std::vector<std::uint8_t>> levels(1, std::vector<std::uint8_t>(size));
  for (std::size_t i = 0; i < table.importance().size(); ++i) {
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

/// Turns a row of 0 and 255 into distances to the nearest 0, at most 255.
void spread_row(std::uint8_t* row, int count) {
  if (count <= 0 || std::memchr(row, 0, as_size(count)) == nullptr) return;
  int near = 255;
  for (int x = 0; x < count; ++x) {
    near = row[x] == 0 ? 0 : std::min(near + 1, 255);
    row[x] = static_cast<std::uint8_t>(near);
  }
  for (int x = count - 1; x >= 0; --x) {
    near = std::min<int>(near + 1, row[x]);
    row[x] = static_cast<std::uint8_t>(near);
  }
}

/// Bricks with a border of 255 around them, so that no pass of chebyshev() meets an end.
class Bordered {
 public:
  Bordered(const Eigen::Vector3i& n, const std::vector<std::uint8_t>& bricks)
      : n_(n),
        bytes_(as_size(n.x() + 2) * as_size(n.y() + 2) * as_size(n.z() + 2), 255),
        near_(as_size(n.x() + 2)) {
    for_each_row([&](std::uint8_t* row, std::size_t at) {
      std::copy_n(bricks.data() + at, n_.x(), row);
      spread_row(row, n_.x());
    });
  }

  /// Lowers every row to one more than the least of the four rows around it that lie before it
  /// (sign 1: less y or z) or behind it (-1). Visits the rows in that order.
  void pass(int sign) {
    const std::ptrdiff_t along_y = sign * (n_.x() + 2);
    const std::ptrdiff_t along_z = along_y * (n_.y() + 2);
    for (int k = 0; k < n_.z(); ++k) {
      for (int j = 0; j < n_.y(); ++j) {
        std::uint8_t* row = sign > 0 ? row_at(j, k) : row_at(n_.y() - 1 - j, n_.z() - 1 - k);
        take_nearest(row - 1, along_y, along_z);
      }
    }
  }

  void copy_to(std::vector<std::uint8_t>& bricks) {
    for_each_row([&](const std::uint8_t* row, std::size_t at) {
      std::copy_n(row, n_.x(), bricks.data() + at);
    });
  }

 private:
  /// The address of the first brick of a row.
  std::uint8_t* row_at(int y, int z) {
    return bytes_.data() + (as_size(z + 1) * as_size(n_.y() + 2) + as_size(y + 1)) * near_.size() +
           1;
  }

  template <class Work>
  void for_each_row(const Work& work) {
    std::size_t at = 0;
    for (int z = 0; z < n_.z(); ++z) {
      for (int y = 0; y < n_.y(); ++y, at += as_size(n_.x())) work(row_at(y, z), at);
    }
  }

  /// row: includes its border.
  void take_nearest(std::uint8_t* row, std::ptrdiff_t along_y, std::ptrdiff_t along_z) {
    const int width = n_.x() + 2;
    std::uint8_t* near = near_.data();
    const std::uint8_t* beside = row - along_y;
    const std::uint8_t* across[3] = {beside - along_z, row - along_z, row + along_y - along_z};
    for (int x = 0; x < width; ++x) {
      near[x] = std::min(std::min(beside[x], across[0][x]), std::min(across[1][x], across[2][x]));
    }
    for (int x = 1; x < width - 1; ++x) {
      const std::uint8_t least = std::min(near[x], std::min(near[x - 1], near[x + 1]));
      const auto one_more = static_cast<std::uint8_t>(std::min<std::uint8_t>(least, 254) + 1);
      row[x] = std::min(row[x], one_more);
    }
  }

  Eigen::Vector3i n_;
  std::vector<std::uint8_t> bytes_;
  std::vector<std::uint8_t> near_;
};

/// Turns 0 and 255 into the Chebyshev distance to the nearest 0, at most 255. Two passes over all
/// neighbours are exact for this metric (Rosenfeld and Pfaltz 1966), because the steps of a
/// shortest path may be sorted: first those along x, then those of the first pass, then those of
/// the second.
void chebyshev(const Eigen::Vector3i& n, std::vector<std::uint8_t>& d) {
  Bordered bordered(n, d);
  bordered.pass(1);
  bordered.pass(-1);
  bordered.copy_to(d);
}

/// Ranges of HU of cubes with edge voxels along each side.
BrickGrid make_ranges(const StoredVolume& volume, int edge, int threads) {
  using Limits = std::numeric_limits<std::int16_t>;
  const auto& size = volume.grid().size;
  BrickGrid grid;
  grid.count = fold_bricks(volume.values().data(), size, edge, threads,
                           BrickFold{Limits::max(), kLeast, grid.low},
                           BrickFold{Limits::min(), kGreatest, grid.high});
  return grid;
}

/// Tests whether ranges of HU may show something. The table must outlive it.
class Visibility {
 public:
  explicit Visibility(const TransferTable& table)
      : before_(table.visible_before()), entries_(table), intervals_(visible_intervals(table)) {}

  /// Writes 1 or 0 to shows for each of the ranges [from, to).
  void of(const BrickGrid& ranges, std::size_t from, std::size_t to, std::uint8_t* shows) const {
    const std::int16_t* low = ranges.low.data();
    const std::int16_t* high = ranges.high.data();
    if (intervals_.size() == 1) {  // Most transfer functions. Compiled to vector instructions.
      const auto [least_high, greatest_low] = intervals_.front();
      for (std::size_t b = from; b < to; ++b) {
        const bool visible = (high[b] >= least_high) & (low[b] <= greatest_low);
        shows[b - from] = static_cast<std::uint8_t>(visible);
      }
      return;
    }
    for (std::size_t b = from; b < to; ++b) {
      const bool visible =
          before_[as_size(entries_.to(high[b]) + 1)] > before_[as_size(entries_.from(low[b]))];
      shows[b - from] = static_cast<std::uint8_t>(visible);
    }
  }

 private:
  const std::vector<int>& before_;
  TouchedEntries entries_;
  std::vector<VisibleInterval> intervals_;
};

/// Adds the bits of a row of parts, bit and bit + 1 of visible_parts(), to a row of bricks.
void add_parts(const std::uint8_t* shows, int parts, unsigned bit, std::uint8_t* bricks) {
  const int pairs = parts / 2;
  for (int x = 0; x < pairs; ++x) {
    const unsigned two = shows[2 * x] | static_cast<unsigned>(shows[2 * x + 1]) << 1;
    bricks[x] = static_cast<std::uint8_t>(bricks[x] | two << bit);
  }
  if (parts % 2 != 0) {  // The other part of the last brick holds no sample.
    bricks[pairs] =
        static_cast<std::uint8_t>(bricks[pairs] | static_cast<unsigned>(shows[parts - 1]) << bit);
  }
}

}  // namespace

BrickGrid make_brick_grid(const StoredVolume& volume, int threads) {
  return make_ranges(volume, kBrickVoxels, threads);
}

BrickGrid make_part_grid(const StoredVolume& volume, int threads) {
  return make_ranges(volume, kPartVoxels, threads);
}

BrickSpan occupied_span(const std::uint8_t* row, int count) {
  const std::uint8_t* end = row + count;
  const std::uint8_t* first = std::find(row, end, 0);
  const auto last = std::find(std::reverse_iterator(end), std::reverse_iterator(first), 0);
  return {static_cast<int>(first - row), static_cast<int>(last.base() - row)};
}

std::vector<std::uint8_t> hidden_bricks(const BrickGrid& bricks, const TransferTable& table,
                                        int threads) {
  std::vector<std::uint8_t> hidden(bricks.low.size());
  const Visibility visibility(table);
  const int slice = bricks.count.x() * bricks.count.y();
  for_each_index(bricks.count.z(), threads, [&](int z) {
    std::uint8_t* shows = hidden.data() + as_size(z * slice);
    visibility.of(bricks, as_size(z * slice), as_size((z + 1) * slice), shows);
    for (int b = 0; b < slice; ++b) shows[b] = static_cast<std::uint8_t>(shows[b] - 1);
  });
  return hidden;
}

BrickDistances brick_distances(const BrickGrid& bricks, std::vector<std::uint8_t> hidden) {
  BrickDistances out{std::move(hidden)};
  out.occupied = static_cast<std::size_t>(std::count(out.distance.begin(), out.distance.end(), 0));
  chebyshev(bricks.count, out.distance);
  return out;
}

BrickDistances brick_distances(const BrickGrid& bricks, const TransferTable& table, int threads) {
  return brick_distances(bricks, hidden_bricks(bricks, table, threads));
}

std::vector<std::uint8_t> brick_depths(const BrickGrid& bricks,
                                       const std::vector<std::uint8_t>& hidden) {
  std::vector<std::uint8_t> depths(bricks.low.size());
  std::transform(hidden.begin(), hidden.begin() + static_cast<std::ptrdiff_t>(depths.size()),
                 depths.begin(),
                 [](std::uint8_t h) { return static_cast<std::uint8_t>(h == 0 ? 255 : 0); });
  chebyshev(bricks.count, depths);
  return depths;
}

std::vector<std::uint8_t> visible_parts(const BrickGrid& parts, const BrickGrid& bricks,
                                        const std::vector<std::uint8_t>& hidden,
                                        const TransferTable& table, int threads) {
  std::vector<std::uint8_t> out(bricks.low.size());
  const Visibility visibility(table);
  for_each_index(bricks.count.z(), threads, [&](int z) {
    std::vector<std::uint8_t> shows(as_size(parts.count.x()));
    for (int y = 0; y < bricks.count.y(); ++y) {
      const std::size_t first = as_size((z * bricks.count.y() + y) * bricks.count.x());
      const std::uint8_t* begin = hidden.data() + first;
      std::uint8_t* row = out.data() + first;
      // Parts before the first and after the last occupied brick are not tested.
      const auto [from, to] = occupied_span(begin, bricks.count.x());
      const int count = std::min(2 * to, parts.count.x()) - 2 * from;
      for (unsigned bit = 0; bit < 8 && from < to; bit += 2) {
        const int j = 2 * y + static_cast<int>(bit >> 1 & 1);
        const int k = 2 * z + static_cast<int>(bit >> 2);
        if (j >= parts.count.y() || k >= parts.count.z()) continue;
        const std::size_t at = as_size((k * parts.count.y() + j) * parts.count.x() + 2 * from);
        visibility.of(parts, at, at + as_size(count), shows.data());
        add_parts(shows.data(), count, bit, row + from);
      }
      const int width = bricks.count.x();
      for (int x = 0; x < width; ++x) {
        row[x] = static_cast<std::uint8_t>(row[x] | (begin[x] != 0 ? 0xFF : 0));
      }
    }
  });
  return out;
}

std::vector<std::uint8_t> brick_importance(const BrickGrid& bricks, const TransferTable& table,
                                           int threads) {
  std::vector<std::uint8_t> out(bricks.low.size());
  const auto levels = importance_levels(table);
  const TouchedEntries entries(table);
  const int slice = bricks.count.x() * bricks.count.y();
  for_each_index(bricks.count.z(), threads, [&](int z) {
    const std::size_t end = as_size((z + 1) * slice);
    for (std::size_t b = as_size(z * slice); b < end; ++b) {
      const std::size_t from = as_size(entries.from(bricks.low[b]));
      const std::size_t past = as_size(entries.to(bricks.high[b]) + 1);
      const auto level = static_cast<std::size_t>(std::bit_width(past - from) - 1);
      const std::vector<std::uint8_t>& greatest = levels[level];
      out[b] = std::max(greatest[from], greatest[past - (std::size_t{1} << level)]);
    }
  });
  return out;
}

}  // namespace nav::render
