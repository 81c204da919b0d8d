// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/skipping/predicate_brick_cache.hpp"

#include <algorithm>

namespace nav::render {
namespace {

bool same_leaf(const PredicateSet::Leaf& a, const PredicateSet::Leaf& b) {
  return a.kind == b.kind && a.values == b.values && a.channels == b.channels;
}

bool by_position(const PredicateSet& set) {
  return std::any_of(set.leaves().begin(), set.leaves().end(),
                     [](const PredicateSet::Leaf& leaf) { return leaf.position; });
}

bool same_channel(const PredicateSet::Channel& a, const PredicateSet::Channel& b) {
  return a.codes == b.codes && a.offset == b.offset && a.scale == b.scale && a.quantum == b.quantum;
}

bool same_labels(const std::optional<LabelVolume>& a, const std::optional<LabelVolume>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->bits().data() == b->bits().data();
}

bool same_leaves(const PredicateSet& a, const PredicateSet& b) {
  return same_labels(a.labels(), b.labels()) &&
         (!by_position(b) || same_surroundings(a.place(), b.place())) &&
         std::equal(a.leaves().begin(), a.leaves().end(), b.leaves().begin(), b.leaves().end(),
                    same_leaf) &&
         std::equal(a.channels().begin(), a.channels().end(), b.channels().begin(),
                    b.channels().end(), same_channel);
}

}  // namespace

bool PredicateBrickCache::knows(const PredicateSet& set) const {
  return set_ && same_leaves(*set_, set);
}

bool PredicateBrickCache::update(const PredicateSet& set, int threads) {
  if (knows(set)) return false;
  set_.reset();
  while (prepare_channel(set, threads)) {
  }
  take_labels(set, threads);
  volume_ = set.channels()[0].codes.get();
  std::vector<const ChannelBricks*> channels;
  for (const auto& channel : set.channels()) {
    channels.push_back(&channels_.at(channel.codes.get()).bricks);
  }
  leaves_ = leaf_bricks(set, channels, set.labels() ? &*label_bricks_ : nullptr, threads);
  set_ = set;
  return true;
}

bool PredicateBrickCache::has_channel(const PredicateSet::Channel& channel) const {
  const auto found = channels_.find(channel.codes.get());
  return found != channels_.end() && !found->second.codes.expired();
}

std::size_t PredicateBrickCache::missing_channels(const PredicateSet& set) const {
  return static_cast<std::size_t>(
      std::count_if(set.channels().begin(), set.channels().end(),
                    [&](const auto& channel) { return !has_channel(channel); }));
}

bool PredicateBrickCache::prepare_channel(const PredicateSet& set, int threads) {
  forget_channels_of_the_past();
  const auto missing = std::find_if(set.channels().begin(), set.channels().end(),
                                    [&](const auto& channel) { return !has_channel(channel); });
  if (missing == set.channels().end()) return false;
  channels_.emplace(missing->codes.get(), Known{missing->codes, channel_bricks(*missing, threads)});
  return true;
}

void PredicateBrickCache::forget_channels_of_the_past() {
  std::erase_if(channels_, [](const auto& known) { return known.second.codes.expired(); });
}

void PredicateBrickCache::take_labels(const PredicateSet& set, int threads) {
  if (label_bricks_ && same_labels(set.labels(), labels_)) return;
  labels_ = set.labels();
  label_bricks_.reset();
  if (labels_) label_bricks_ = label_bricks(*labels_, threads);
}

std::vector<std::uint8_t> visible_distances(const BrickGrid& grid,
                                            const std::vector<double>& importances) {
  std::vector<std::uint8_t> visible(importances.size());
  std::transform(importances.begin(), importances.end(), visible.begin(),
                 [](double importance) { return static_cast<std::uint8_t>(importance > 0); });
  return brick_depths(grid, visible);
}

std::vector<KnownAround> known_around(const Eigen::Vector3i& count,
                                      const std::vector<double>& importances,
                                      const LeafBricks& leaves) {
  std::vector<KnownAround> known(importances.size());
  for (std::size_t b = 0; b < known.size(); ++b) {
    const auto sure = static_cast<std::uint32_t>(leaves.sure[b]);
    known[b] = {importances[b], sure, sure | static_cast<std::uint32_t>(leaves.open[b])};
  }
  std::size_t stride = 1;
  for (int axis = 0; axis < 3; ++axis) {  // A box is processed axis by axis.
    const std::vector<KnownAround> before = known;
    const auto n = static_cast<std::size_t>(count[axis]);
    for (std::size_t b = 0; b < known.size(); ++b) {
      const std::size_t i = b / stride % n;
      const auto join = [&](const KnownAround& other) {
        known[b] = {std::max(known[b].importance, other.importance), known[b].sure & other.sure,
                    known[b].some | other.some};
      };
      if (i > 0) join(before[b - stride]);
      if (i + 1 < n) join(before[b + stride]);
    }
    stride *= n;
  }
  return known;
}

}  // namespace nav::render
