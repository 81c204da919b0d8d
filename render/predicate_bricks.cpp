// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicate_bricks.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <unordered_map>

#include "render/parallel.hpp"

namespace nav::render {
namespace {

std::size_t size_of(int n) { return static_cast<std::size_t>(n); }

/// More than single precision takes from an interpolated code, an index and what follows of them.
constexpr double kCodeSlack = 0.05;
constexpr double kIndexSlack = 0.01;

/// For every row of bricks of a layer: rows.begin(), rows.add(first voxel) for each row of voxels
/// in it, rows.end(first brick).
template <class Rows>
void for_each_brick_row(const std::array<int, 3>& size, int bz, Rows&& rows) {
  const auto bricks = [&](int axis) { return (size[size_of(axis)] - 1) / kBrickVoxels + 1; };
  const auto end = [&](int b, int axis) {
    return std::min((b + 1) * kBrickVoxels + 1, size[size_of(axis)]);
  };
  for (int by = 0; by < bricks(1); ++by) {
    rows.begin();
    for (int k = bz * kBrickVoxels; k < end(bz, 2); ++k) {
      for (int j = by * kBrickVoxels; j < end(by, 1); ++j) {
        rows.add((size_of(k) * size_of(size[1]) + size_of(j)) * size_of(size[0]));
      }
    }
    rows.end(size_of((bz * bricks(1) + by) * bricks(0)));
  }
}

/// Of each column of voxels through a row of bricks a running value, of each brick that of its
/// columns. Column by column first: the compiler turns long rows into vector instructions.
template <class T, class Join>
class BrickFold {
 public:
  BrickFold(int voxels, T neutral, Join join, std::vector<T>& bricks)
      : neutral_(neutral), join_(join), columns_(size_of(voxels)), bricks_(bricks) {}

  void begin() { std::fill(columns_.begin(), columns_.end(), neutral_); }
  template <class Get>
  void add(const Get& get) {
    T* columns = columns_.data();
    for (std::size_t i = 0; i < columns_.size(); ++i) columns[i] = join_(columns[i], get(i));
  }
  void end(std::size_t brick) {
    for (std::size_t first = 0; first < columns_.size(); first += kBrickVoxels) {
      const std::size_t last = std::min(first + kBrickVoxels + 1, columns_.size());
      T joined = neutral_;
      for (std::size_t i = first; i < last; ++i) joined = join_(joined, columns_[i]);
      bricks_[brick++] = joined;
    }
  }

 private:
  T neutral_;
  Join join_;
  std::vector<T> columns_;
  std::vector<T>& bricks_;
};

constexpr auto kLeast = [](auto a, auto b) { return std::min(a, b); };

std::size_t brick_count(const std::array<int, 3>& size) {
  std::size_t count = 1;
  for (const int n : size) count *= size_of((n - 1) / kBrickVoxels + 1);
  return count;
}

/// Where and what one brick is.
class BrickReader {
 public:
  BrickReader(const PredicateSet& set, const std::vector<const ChannelBricks*>& channels,
              const LabelBricks* labels)
      : set_(set), channels_(channels), labels_(labels), count_(channels[0]->range.count) {}

  [[nodiscard]] PredicateBounds place(std::size_t b) const {
    PredicateBounds out{};
    const VoxelGrid& grid = set_.place().grid;
    auto rest = static_cast<int>(b);
    for (int axis = 0; axis < 3; ++axis) {
      const int i = rest % count_[axis];
      rest /= count_[axis];
      const int last = grid.size[size_of(axis)] - 1;
      const double low = i * kBrickVoxels - kIndexSlack;
      const double high = std::min((i + 1) * kBrickVoxels, last) + kIndexSlack;
      out.low_mm[axis] = low * grid.spacing_mm[axis];
      out.high_mm[axis] = high * grid.spacing_mm[axis];
    }
    if (labels_ != nullptr) {
      out.labels_any = labels_->any[b];
      out.labels_all = labels_->all[b];
    }
    return out;
  }

  [[nodiscard]] Truth truth(std::size_t b, const PredicateSet::Leaf& leaf,
                            PredicateBounds& bounds) const {
    for (std::size_t c = 0; c < leaf.channels.size(); ++c) {
      const auto i = size_of(leaf.channels[c]);
      const PredicateSet::Channel& channel = set_.channels()[i];
      const ChannelBricks& bricks = *channels_[i];
      if (bricks.range.low[b] > bricks.range.high[b])
        return Truth::kFalse;  // Undefined, all of it.
      bounds.value[c] = {channel.offset + channel.scale * (bricks.range.low[b] - kCodeSlack),
                         channel.offset + channel.scale * (bricks.range.high[b] + kCodeSlack)};
      bounds.quantum[c] = channel.quantum;
      bounds.undefined[c] = !bricks.undefined.empty() && bricks.undefined[b] != 0;
    }
    return leaf.kind->bounds(bounds, set_.place(), leaf.values);
  }

 private:
  const PredicateSet& set_;
  const std::vector<const ChannelBricks*>& channels_;
  const LabelBricks* labels_;
  Eigen::Vector3i count_;
};

}  // namespace

ChannelBricks channel_bricks(const PredicateSet::Channel& channel, int threads) {
  ChannelBricks out{make_brick_grid(*channel.codes, threads), {}};
  if (!channel.has_undefined) return out;
  const auto& size = channel.codes->grid().size;
  const std::int16_t* codes = channel.codes->hu().data();
  constexpr std::int16_t kUndefined = FeatureVolume::kUndefined;
  constexpr std::int16_t kMost = std::numeric_limits<std::int16_t>::max();
  // No code is less than an undefined one: the least says where there are some, the greatest is as
  // it was.
  static_assert(kUndefined == std::numeric_limits<std::int16_t>::min());
  out.undefined.resize(out.range.low.size());
  std::transform(out.range.low.begin(), out.range.low.end(), out.undefined.begin(),
                 [](std::int16_t low) { return static_cast<std::uint8_t>(low == kUndefined); });
  struct Rows {
    const std::int16_t* codes;
    BrickFold<std::int16_t, decltype(kLeast)> low;
    void begin() { low.begin(); }
    void add(std::size_t first) {
      const std::int16_t* row = codes + first;
      low.add([row](std::size_t i) { return row[i] == kUndefined ? kMost : row[i]; });
    }
    void end(std::size_t brick) { low.end(brick); }
  };
  for_each_index(out.range.count.z(), threads, [&](int bz) {
    for_each_brick_row(size, bz, Rows{codes, {size[0], kMost, kLeast, out.range.low}});
  });
  return out;
}

LabelBricks label_bricks(const LabelVolume& labels, int threads) {
  const auto& size = labels.grid().size;
  const std::size_t count = brick_count(size);
  LabelBricks out{std::vector<std::uint32_t>(count), std::vector<std::uint32_t>(count)};
  using Any = std::bit_or<std::uint32_t>;
  using All = std::bit_and<std::uint32_t>;
  struct Rows {
    const std::uint32_t* bits;
    BrickFold<std::uint32_t, Any> any;
    BrickFold<std::uint32_t, All> all;
    void begin() {
      any.begin();
      all.begin();
    }
    void add(std::size_t first) {
      const std::uint32_t* row = bits + first;
      any.add([row](std::size_t i) { return row[i]; });
      all.add([row](std::size_t i) { return row[i]; });
    }
    void end(std::size_t brick) {
      any.end(brick);
      all.end(brick);
    }
  };
  for_each_index((size[2] - 1) / kBrickVoxels + 1, threads, [&](int bz) {
    for_each_brick_row(
        size, bz,
        Rows{labels.bits().data(), {size[0], 0U, Any{}, out.any}, {size[0], ~0U, All{}, out.all}});
  });
  return out;
}

LeafBricks leaf_bricks(const PredicateSet& set, const std::vector<const ChannelBricks*>& channels,
                       const LabelBricks* labels, int threads) {
  const BrickReader reader(set, channels, labels);
  const Eigen::Vector3i& n = channels[0]->range.count;
  const std::size_t count = size_of(n.prod());
  LeafBricks out{std::vector<std::int32_t>(count), std::vector<std::int32_t>(count),
                 std::vector<std::uint8_t>(count)};
  const PredicateSet::Channel& volume = set.channels()[0];
  const std::size_t slice = size_of(n.x() * n.y());
  for_each_index(n.z(), threads, [&](int z) {
    for (std::size_t b = size_of(z) * slice; b < size_of(z + 1) * slice; ++b) {
      // Rounding cannot brighten what is black by more than the slack.
      const double most = channels[0]->range.high[b] + kCodeSlack;
      out.dark[b] = volume.offset + volume.scale * most <= 0 ? 1 : 0;
      if (out.dark[b] != 0) continue;
      PredicateBounds bounds = reader.place(b);
      for (std::size_t i = 0; i < set.leaves().size(); ++i) {
        const Truth truth = reader.truth(b, set.leaves()[i], bounds);
        const auto bit = static_cast<std::int32_t>(1U << i);
        if (truth == Truth::kTrue) out.sure[b] |= bit;
        if (truth == Truth::kUnknown) out.open[b] |= bit;
      }
    }
  });
  return out;
}

std::vector<double> brick_importances(const PredicateSet& set, const LeafBricks& leaves,
                                      int threads) {
  std::vector<double> out(leaves.sure.size());
  constexpr std::size_t kChunk = 4096;
  const auto chunks = static_cast<int>((out.size() + kChunk - 1) / kChunk);
  for_each_index(chunks, threads, [&](int chunk) {
    // Few combinations occur.
    std::unordered_map<std::uint64_t, double> seen;
    std::vector<Truth> truths(set.leaves().size());
    const std::size_t end = std::min(out.size(), (size_of(chunk) + 1) * kChunk);
    for (std::size_t b = size_of(chunk) * kChunk; b < end; ++b) {
      if (leaves.dark[b] != 0) continue;
      const auto sure = static_cast<std::uint32_t>(leaves.sure[b]);
      const auto open = static_cast<std::uint32_t>(leaves.open[b]);
      const auto [at, fresh] = seen.try_emplace((std::uint64_t{sure} << 32) | open, 0);
      if (fresh) {
        for (std::size_t i = 0; i < truths.size(); ++i) {
          truths[i] = ((open >> i) & 1U) != 0 ? Truth::kUnknown : truth_of(((sure >> i) & 1U) != 0);
        }
        at->second = set.possible(truths).importance;
      }
      out[b] = at->second;
    }
  });
  return out;
}

}  // namespace nav::render
