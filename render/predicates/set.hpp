// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/predicates/kind.hpp"
#include "render/predicates/predicate_scene.hpp"
#include "render/predicates/program.hpp"

namespace nav::render {

/// Greatest number of different point predicates in a model: one bit for each.
inline constexpr std::size_t kMostLeaves = 32;
/// Greatest number of conditions for which the appearance of samples is tabulated: 2^12 entries, 64
/// KB.
inline constexpr std::size_t kMostTabulated = 12;

/// A model prepared for a volume: its different point predicates ("leaves"), the data that they
/// read, and their combinations. Immutable, thread-safe.
class PredicateSet {
 public:
  struct Channel {
    std::string name;
    std::shared_ptr<const StoredVolume> codes;
    double offset;  ///< value = offset + scale · code.
    double scale;
    double quantum;
    bool has_undefined;
  };
  struct Leaf {
    const PredicateKind* kind;
    std::vector<double> values;
    std::vector<int> channels{};  ///< Indices into channels().
    bool labels;
    bool position;
  };

  /// Rejects what validate(PredicateScene) lists.
  static Result<PredicateSet> create(const PredicateScene& predicates,
                                     const std::shared_ptr<const StoredVolume>& ct,
                                     PredicatePosition place);

  /// The channels that leaves read. The first is the volume itself.
  [[nodiscard]] const std::vector<Channel>& channels() const { return channels_; }
  /// Present only if a leaf needs labels.
  [[nodiscard]] const std::optional<LabelVolume>& labels() const { return labels_; }
  [[nodiscard]] const std::vector<Leaf>& leaves() const { return leaves_; }
  [[nodiscard]] const std::vector<PredicateProgram>& programs() const { return programs_; }
  [[nodiscard]] const PredicatePosition& place() const { return place_; }
  [[nodiscard]] std::size_t size() const { return weights_.size(); }
  /// Weights of the entries, in order.
  [[nodiscard]] const std::vector<spec::PredicateWeight>& weights() const { return weights_; }
  [[nodiscard]] spec::HueMean hue_mean() const { return hue_mean_; }

  /// The entry with the greatest impact, the first of equals.
  [[nodiscard]] std::size_t most_important() const {
    return static_cast<std::size_t>(by_impact_.front());
  }
  /// The greatest impact of an entry.
  [[nodiscard]] double greatest_impact() const { return greatest_; }
  /// True when all visible samples are equally important.
  [[nodiscard]] bool uniform() const { return greatest_ == least_; }

  [[nodiscard]] bool test(const Leaf& leaf, const PredicateSample& sample) const {
    return leaf.kind->test(sample, place_, leaf.values);
  }
  /// Bits of the entries that are true when these leaves are true.
  [[nodiscard]] std::uint32_t mask_of(std::uint32_t leaf_bits) const;
  [[nodiscard]] spec::PredicateClass class_of(std::uint32_t mask) const {
    return spec::classify(mask, weights_, hue_mean_);
  }

  /// Bounds for a set of samples.
  struct Possible {
    std::uint32_t sure = 0;  ///< Entries that are true for all samples.
    std::uint32_t open = 0;  ///< Entries that may be true or false.
    double importance = 0;   ///< Upper bound of the samples' importance; 0: all are invisible.
  };
  [[nodiscard]] Possible possible(const std::vector<Truth>& leaves) const;
  /// The greatest mean impact of the sure entries together with any of the open ones.
  [[nodiscard]] double greatest_mean(std::uint32_t sure, std::uint32_t open) const;

 private:
  PredicateSet() = default;
  friend class PredicateSetBuilder;

  std::vector<Channel> channels_;
  std::optional<LabelVolume> labels_;
  std::vector<Leaf> leaves_;
  std::vector<PredicateProgram> programs_;  ///< An entry comes after the entries that it refers to.
  PredicatePosition place_;
  std::vector<spec::PredicateWeight> weights_;
  std::vector<int> by_impact_;  ///< Entries in order of descending impact.
  spec::HueMean hue_mean_ = spec::HueMean::kCircular;
  double greatest_ = 0;
  double least_ = 0;
};

}  // namespace nav::render
