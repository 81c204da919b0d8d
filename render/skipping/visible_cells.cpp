// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/skipping/visible_cells.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstring>

#include "nav/index.hpp"
#include "render/parallel.hpp"
#include "render/skipping/visible_intervals.hpp"

namespace nav::render {
namespace {

constexpr int kWordBits = 32;
constexpr int kCellsAtOnce = 8;
/// The largest number of intervals of visible values. Beyond it the nearest neighbours are joined;
/// some cells then count as visible without need.
constexpr std::size_t kMostIntervals = 6;

std::vector<VisibleInterval> few_intervals(const TransferTable& table) {
  std::vector<VisibleInterval> out = visible_intervals(table);
  while (out.size() > kMostIntervals) {
    const auto gap = [&](std::size_t i) { return out[i + 1].least_high - out[i].greatest_low; };
    std::size_t nearest = 0;
    for (std::size_t i = 1; i + 1 < out.size(); ++i) {
      if (gap(i) < gap(nearest)) nearest = i;
    }
    out[nearest].greatest_low = out[nearest + 1].greatest_low;
    out.erase(out.begin() + static_cast<std::ptrdiff_t>(nearest) + 1);
  }
  return out;
}

/// Finds the visible cells of one row after the other.
class CellRow {
 public:
  /// ct: gives the width of the rows.
  CellRow(const StoredVolume& ct, const std::vector<VisibleInterval>& intervals)
      : ct_(ct),
        intervals_(intervals),
        low_(as_size(ct.grid().size[0]) + 1),
        high_(low_.size()),
        shows_(low_.size() + kCellsAtOnce) {}

  void clear() { std::fill(shows_.begin(), shows_.end(), std::uint8_t{0}); }

  /// Adds the cells [from, to) of row j, k.
  void add(int j, int k, int from, int to) {
    const auto& n = ct_.grid().size;
    const int j1 = std::min(j + 1, n[1] - 1);
    const int k1 = std::min(k + 1, n[2] - 1);
    const std::int16_t* rows[4] = {row(j, k), row(j1, k), row(j, k1), row(j1, k1)};
    const int end = std::min(to + 1, n[0]);
    std::int16_t* low = low_.data();
    std::int16_t* high = high_.data();
    for (int i = from; i < end; ++i) {
      low[i] = std::min(std::min(rows[0][i], rows[1][i]), std::min(rows[2][i], rows[3][i]));
      high[i] = std::max(std::max(rows[0][i], rows[1][i]), std::max(rows[2][i], rows[3][i]));
    }
    if (end == to) {  // The cell of the last voxel is flat.
      low[to] = low[to - 1];
      high[to] = high[to - 1];
    }
    std::uint8_t* shows = shows_.data();
    for (const VisibleInterval& interval : intervals_) {
      const std::int16_t least_high = interval.least_high;  // A copy, because the compiler must
                                                            // assume that bytes alias the interval.
      const std::int16_t greatest_low = interval.greatest_low;
      for (int i = from; i < to; ++i) {
        const bool visible = (std::max(high[i], high[i + 1]) >= least_high) &
                             (std::min(low[i], low[i + 1]) <= greatest_low);
        shows[i] = static_cast<std::uint8_t>(shows[i] | static_cast<std::uint8_t>(visible));
      }
    }
  }

  /// Makes blocks of edge cells in [from, to) uniform: all visible or none. Precondition: from is a
  /// multiple of edge.
  void join(int edge, int from, int to) {
    for (int i = from; i < to; i += edge) {
      const auto begin = shows_.begin() + i;
      const auto end = begin + std::min(edge, to - i);
      std::fill(begin, end, *std::max_element(begin, end));
    }
  }

  /// Sets the bits of the cells [from, to); `first` is the bit of cell `from`. Returns the number
  /// of visible cells. Threads may share words.
  std::size_t put(std::int32_t* words, std::size_t first, int from, int to) const {
    std::int32_t* word = words + first / kWordBits;
    unsigned waiting = static_cast<unsigned>(first % kWordBits);
    std::uint64_t bits = 0;
    std::size_t count = 0;
    const auto flush = [&] {
      const auto lower = static_cast<std::uint32_t>(bits);
      count += static_cast<std::size_t>(std::popcount(lower));
      if (lower != 0) {
        std::atomic_ref(*word).fetch_or(static_cast<std::int32_t>(lower),
                                        std::memory_order_relaxed);
      }
      ++word;
    };
    for (int i = from; i < to; i += kCellsAtOnce) {
      bits |= eight(i, to) << waiting;
      waiting += kCellsAtOnce;
      if (waiting < kWordBits) continue;
      flush();
      bits >>= kWordBits;
      waiting -= kWordBits;
    }
    if (bits != 0) flush();
    return count;
  }

 private:
  [[nodiscard]] const std::int16_t* row(int j, int k) const {
    const auto& n = ct_.grid().size;
    return ct_.values().data() + (as_size(k) * as_size(n[1]) + as_size(j)) * as_size(n[0]);
  }

  /// One bit for each of eight cells; cells from `to` on are clear.
  [[nodiscard]] std::uint64_t eight(int i, int to) const {
    std::array<std::uint8_t, kCellsAtOnce> bytes{};
    std::memcpy(bytes.data(), shows_.data() + i, kCellsAtOnce);
    std::uint64_t eight = 0;
    if constexpr (std::endian::native == std::endian::little) {
      std::memcpy(&eight, bytes.data(), kCellsAtOnce);
      eight = eight * 0x0102040810204080U >> 56;
    } else {
      for (unsigned bit = 0; bit < kCellsAtOnce; ++bit) eight |= std::uint64_t{bytes[bit]} << bit;
    }
    return to - i < kCellsAtOnce ? eight & ((1U << (to - i)) - 1) : eight;
  }

  const StoredVolume& ct_;
  const std::vector<VisibleInterval>& intervals_;
  std::vector<std::int16_t> low_;  ///< Least of the four rows around a row of cells.
  std::vector<std::int16_t> high_;
  std::vector<std::uint8_t> shows_;  ///< 1: visible.
};

}  // namespace

VisibleCells::VisibleCells(const StoredVolume& ct, const CpuVolume& layout,
                           const BrickDistances& distances, const TransferTable& table, int edge,
                           int threads) {
  const auto& n = ct.grid().size;
  const auto at = [&](int i, int j, int k) {
    return as_size(k) * as_size(layout.slice_stride()) + as_size(j) * as_size(layout.row_stride()) +
           as_size(i);
  };
  words_.assign(at(n[0] - 1, n[1] - 1, n[2] - 1) / kWordBits + 1, 0);
  const std::vector<VisibleInterval> intervals = few_intervals(table);
  const auto bricks = [](int voxels) { return (voxels - 1) / kBrickVoxels + 1; };
  std::atomic<std::size_t> count = 0;
  for_each_index(bricks(n[2]), threads, [&](int brick_k) {
    CellRow row(ct, intervals);
    std::size_t visible = 0;
    const int past_k = std::min((brick_k + 1) * kBrickVoxels, n[2]);
    for (int j = 0; j < n[1]; j += edge) {
      // Nothing is visible before the first and after the last occupied brick.
      const std::size_t first = as_size((brick_k * bricks(n[1]) + j / kBrickVoxels) * bricks(n[0]));
      const BrickSpan span = occupied_span(distances.distance.data() + first, bricks(n[0]));
      if (span.from == span.to) continue;
      const int from = span.from * kBrickVoxels;
      const int to = std::min(span.to * kBrickVoxels, n[0]);
      const int past_j = std::min(j + edge, n[1]);
      for (int k = brick_k * kBrickVoxels; k < past_k; k += edge) {
        const int last_k = std::min(k + edge, n[2]);
        row.clear();
        for (int z = k; z < last_k; ++z) {
          for (int y = j; y < past_j; ++y) row.add(y, z, from, to);
        }
        if (edge > 1) row.join(edge, from, to);
        for (int z = k; z < last_k; ++z) {
          for (int y = j; y < past_j; ++y)
            visible += row.put(words_.data(), at(from, y, z), from, to);
        }
      }
    }
    count += visible;
  });
  count_ = count;
}

}  // namespace nav::render
