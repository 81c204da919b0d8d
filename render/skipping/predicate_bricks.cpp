// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/skipping/predicate_bricks.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <unordered_map>

#include "nav/index.hpp"
#include "render/parallel.hpp"
#include "render/skipping/brick_fold.hpp"

namespace nav::render {
namespace {

/// Larger than the error of single precision in an interpolated code, an index and values derived
/// from them.
constexpr double kCodeSlack = 0.05;
constexpr double kIndexSlack = 0.01;
/// Larger than its error in offset + scale · code, as a share of the greatest such value.
constexpr double kValueSlack = 4.0 / (1 << 23);

/// Reads the position and the values of one brick.
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
      const int last = grid.size[as_size(axis)] - 1;
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
      const auto i = as_size(leaf.channels[c]);
      const PredicateSet::Channel& channel = set_.channels()[i];
      const ChannelBricks& bricks = *channels_[i];
      if (bricks.range.low[b] > bricks.range.high[b])
        return Truth::kFalse;  // Undefined everywhere.
      const double low = channel.offset + channel.scale * (bricks.range.low[b] - kCodeSlack);
      const double high = channel.offset + channel.scale * (bricks.range.high[b] + kCodeSlack);
      const double greatest = std::max({std::abs(low), std::abs(high), std::abs(channel.offset)});
      const double slack = kValueSlack * greatest;
      bounds.value[c] = {low - slack, high + slack};
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
  if (!channel.has_undefined) return {make_brick_grid(*channel.codes, threads), {}};
  using Limits = std::numeric_limits<std::int16_t>;
  constexpr std::int16_t kUndefined = FeatureVolume::kUndefined;
  // No code is less than the undefined one, so the greatest code needs no special case.
  static_assert(kUndefined == Limits::min());
  const auto least_defined = [](std::int16_t least, std::int16_t code) {
    return std::min(least, code == kUndefined ? Limits::max() : code);
  };
  const auto& size = channel.codes->grid().size;
  ChannelBricks out{};
  std::vector<std::int16_t> least;
  out.range.count = fold_bricks(channel.codes->values().data(), size, kBrickVoxels, threads,
                                BrickFold{Limits::max(), least_defined, out.range.low},
                                BrickFold{Limits::min(), kGreatest, out.range.high},
                                BrickFold{Limits::max(), kLeast, least});
  out.undefined.resize(least.size());
  std::transform(least.begin(), least.end(), out.undefined.begin(),
                 [](std::int16_t code) { return static_cast<std::uint8_t>(code == kUndefined); });
  return out;
}

LabelBricks label_bricks(const LabelVolume& labels, int threads) {
  LabelBricks out;
  fold_bricks(labels.bits().data(), labels.grid().size, kBrickVoxels, threads,
              BrickFold{0U, std::bit_or<std::uint32_t>(), out.any},
              BrickFold{~0U, std::bit_and<std::uint32_t>(), out.all});
  return out;
}

LeafBricks leaf_bricks(const PredicateSet& set, const std::vector<const ChannelBricks*>& channels,
                       const LabelBricks* labels, int threads) {
  const BrickReader reader(set, channels, labels);
  const Eigen::Vector3i& n = channels[0]->range.count;
  const std::size_t count = as_size(n.prod());
  LeafBricks out{std::vector<std::int32_t>(count), std::vector<std::int32_t>(count),
                 std::vector<std::uint8_t>(count)};
  const PredicateSet::Channel& volume = set.channels()[0];
  const std::size_t slice = as_size(n.x() * n.y());
  for_each_index(n.z(), threads, [&](int z) {
    for (std::size_t b = as_size(z) * slice; b < as_size(z + 1) * slice; ++b) {
      // Rounding cannot brighten a black value by more than the slack.
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
    // Only few combinations occur.
    std::unordered_map<std::uint64_t, double> seen;
    std::vector<Truth> truths(set.leaves().size());
    const std::size_t end = std::min(out.size(), (as_size(chunk) + 1) * kChunk);
    for (std::size_t b = as_size(chunk) * kChunk; b < end; ++b) {
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
