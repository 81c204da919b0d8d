// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/set.hpp"

#include <algorithm>
#include <numeric>

#include "render/predicates/registry.hpp"

namespace nav::render {
namespace {

using Operator = PredicateExpression::Operator;
using Op = PredicateProgram::Op;

bool same_grid(const VoxelGrid& a, const VoxelGrid& b) {
  return a.size == b.size && a.spacing_mm == b.spacing_mm && a.origin_mm == b.origin_mm &&
         a.directions == b.directions;
}

std::string size_text(const VoxelGrid& grid) {
  return std::to_string(grid.size[0]) + " x " + std::to_string(grid.size[1]) + " x " +
         std::to_string(grid.size[2]);
}

Result<void> check_grid(const std::string& name, const VoxelGrid& found, const VoxelGrid& wanted) {
  if (same_grid(found, wanted)) return {};
  return malformed_predicates("feature " + name + ": expected the grid of the volume, " +
                              size_text(wanted) + " voxels, found another grid of " +
                              size_text(found));
}

}  // namespace

/// Collects leaves and channels while it visits a model.
class PredicateSetBuilder {
 public:
  PredicateSetBuilder(const PredicateScene& predicates,
                      const std::shared_ptr<const StoredVolume>& ct, PredicatePosition place)
      : predicates_(predicates), ct_(ct) {
    const auto& window = predicates.intensity;
    const double scale = 1 / (window.white - window.black);
    // Integer stored values are exact, except for the rounding of the window.
    constexpr double kRounding = 1e-6;
    set_.channels_.push_back({.name = feature::kIntensity,
                              .codes = ct,
                              .offset = -window.black * scale,
                              .scale = scale,
                              .quantum = kRounding * scale,
                              .has_undefined = false});
    set_.place_ = std::move(place);
    set_.hue_mean_ = predicates.hue_mean;
  }

  Result<PredicateSet> build() {
    const auto& entries = predicates_.model.entries;
    done_.assign(entries.size(), false);
    for (std::size_t j = 0; j < entries.size(); ++j) {
      if (const auto ok = add_entry(j); !ok) return ok.error();
    }
    weigh();
    return std::move(set_);
  }

 private:
  Result<void> add_entry(std::size_t j) {
    if (done_[j]) return {};
    PredicateProgram program{static_cast<int>(j), {}};
    const PredicateEntry& entry = predicates_.model.entries[j];
    if (const auto ok = add(entry, entry.expression, 1, program); !ok) return ok;
    set_.programs_.push_back(std::move(program));
    done_[j] = true;
    return {};
  }

  Result<void> add(const PredicateEntry& entry, const PredicateExpression& e, std::size_t stack,
                   PredicateProgram& program) {
    NAV_CHECK(stack < kProgramStack, stack);  // Validation limits the nesting.
    switch (e.op) {
      case Operator::kKind:
        return add_leaf(entry, e, program);
      case Operator::kEntry:
        return add_reference(e.name, program);
      case Operator::kConnected:
        return malformed_predicates(entry.name +
                                    ": expected connected parts that were resolved for a volume, "
                                    "found unresolved ones");
      case Operator::kNot:
      case Operator::kAnd:
      case Operator::kOr:
        break;
    }
    for (std::size_t i = 0; i < e.operands.size(); ++i) {
      if (const auto ok = add(entry, e.operands[i], stack + (i > 0 ? 1 : 0), program); !ok) {
        return ok;
      }
      if (i > 0) program.tokens.push_back({e.op == Operator::kAnd ? Op::kAnd : Op::kOr, 0});
    }
    if (e.op == Operator::kNot) program.tokens.push_back({Op::kNot, 0});
    return {};
  }

  Result<void> add_reference(const std::string& name, PredicateProgram& program) {
    const auto& entries = predicates_.model.entries;
    const auto found = std::find_if(entries.begin(), entries.end(),
                                    [&](const PredicateEntry& e) { return e.name == name; });
    const auto j = static_cast<std::size_t>(found - entries.begin());
    NAV_CHECK(j < entries.size(), name);
    if (const auto ok = add_entry(j); !ok) return ok;
    program.tokens.push_back({Op::kEntry, static_cast<std::uint8_t>(j)});
    return {};
  }

  Result<void> add_leaf(const PredicateEntry& entry, const PredicateExpression& e,
                        PredicateProgram& program) {
    const auto kind = find_predicate_kind(e.name);
    if (!kind) return kind.error();
    std::vector<double> values = e.values;
    if (values.empty()) {
      for (const auto& parameter : (*kind)->parameters()) values.push_back(parameter.initial);
    }
    const auto push = [&](std::size_t leaf) {
      program.tokens.push_back({Op::kLeaf, static_cast<std::uint8_t>(leaf)});
    };
    for (std::size_t i = 0; i < set_.leaves_.size(); ++i) {
      if (set_.leaves_[i].kind == *kind && set_.leaves_[i].values == values) {
        push(i);
        return {};
      }
    }
    if (set_.leaves_.size() == kMostLeaves) {
      return malformed_predicates("predicates: expected at most " + std::to_string(kMostLeaves) +
                                  " different predicates in all combinations together, found more");
    }
    push(set_.leaves_.size());
    return read(entry.name + ": " + e.name, **kind, std::move(values));
  }

  /// Finds the channels and labels that a new leaf reads.
  Result<void> read(const std::string& name, const PredicateKind& kind,
                    std::vector<double> values) {
    const PredicatePosition& place = set_.place_;
    const PredicateNeeds needs = kind.needs(place);
    if (needs.scan && !place.scan) {
      return malformed_predicates(name +
                                  ": expected scan-line directions of the volume, found none");
    }
    if (needs.needle && !place.needle) {
      return malformed_predicates(name + ": expected a needle in the scene, found none");
    }
    if (needs.target && !place.target) {
      return malformed_predicates(name + ": expected a target in the scene, found none");
    }
    PredicateSet::Leaf leaf{.kind = &kind,
                            .values = std::move(values),
                            .labels = needs.labels,
                            .position = needs.position};
    for (const std::string& channel : needs.channels) {
      const auto at = channel_of(name, channel);
      if (!at) return at.error();
      leaf.channels.push_back(*at);
    }
    if (needs.labels && !set_.labels_) {
      const auto& labels = predicates_.features.labels;
      if (!labels) return malformed_predicates(name + ": expected a label volume, found none");
      if (const auto ok = check_grid(labels->name(), labels->grid(), ct_->grid()); !ok) return ok;
      set_.labels_ = labels;
    }
    set_.leaves_.push_back(std::move(leaf));
    return {};
  }

  Result<int> channel_of(const std::string& who, const std::string& name) {
    const auto& volumes = predicates_.features.volumes;
    const auto found = volumes.find(name);
    // A feature of the name of the volume itself takes its place for predicates.
    const bool replaced = name == feature::kIntensity && found != volumes.end();
    for (std::size_t i = replaced ? 1 : 0; i < set_.channels_.size(); ++i) {
      if (set_.channels_[i].name == name) return static_cast<int>(i);
    }
    if (found == volumes.end()) {
      std::string known;
      for (const auto& [key, volume] : volumes) known += (known.empty() ? "" : ", ") + key;
      return malformed_predicates(who + ": expected a feature volume " + name + ", found " +
                                  (known.empty() ? "none" : "only " + known));
    }
    const FeatureVolume& volume = found->second;
    if (const auto ok = check_grid(name, volume.grid(), ct_->grid()); !ok) return ok.error();
    set_.channels_.push_back({.name = name,
                              .codes = volume.codes(),
                              .offset = volume.offset(),
                              .scale = volume.scale(),
                              .quantum = volume.quantum(),
                              .has_undefined = volume.has_undefined()});
    return static_cast<int>(set_.channels_.size() - 1);
  }

  void weigh() {
    const auto& bars = predicates_.model.histogram.bars();
    for (const auto& bar : bars) {
      set_.weights_.push_back(
          {spec::impact_of(bar.importance, bars.size()), bar.hue_deg, bar.saturation});
    }
    set_.by_impact_.resize(bars.size());
    std::iota(set_.by_impact_.begin(), set_.by_impact_.end(), 0);
    const auto impact = [&](int j) { return set_.weights_[static_cast<std::size_t>(j)].impact; };
    std::stable_sort(set_.by_impact_.begin(), set_.by_impact_.end(),
                     [&](int a, int b) { return impact(a) > impact(b); });
    set_.greatest_ = impact(set_.by_impact_.front());
    // The mean of several impacts may have any value between the least and the greatest.
    set_.least_ = impact(set_.by_impact_.back());
  }

  const PredicateScene& predicates_;
  const std::shared_ptr<const StoredVolume>& ct_;
  PredicateSet set_;
  std::vector<bool> done_;
};

Result<PredicateSet> PredicateSet::create(const PredicateScene& predicates,
                                          const std::shared_ptr<const StoredVolume>& ct,
                                          PredicatePosition place) {
  if (const auto ok = nav::render::validate(predicates.model); !ok) return ok.error();
  return PredicateSetBuilder(predicates, ct, std::move(place)).build();
}

std::uint32_t PredicateSet::mask_of(std::uint32_t leaf_bits) const {
  std::array<bool, kMostPredicates> result{};
  run_programs(
      programs_, [&](int i) { return ((leaf_bits >> i) & 1U) != 0; }, [](bool a) { return !a; },
      [](bool a, bool b) { return a && b; }, [](bool a, bool b) { return a || b; }, result);
  std::uint32_t mask = 0;
  for (std::size_t j = 0; j < size(); ++j) mask |= (result[j] ? 1U : 0U) << j;
  return mask;
}

PredicateSet::Possible PredicateSet::possible(const std::vector<Truth>& leaves) const {
  std::array<Truth, kMostPredicates> result{};
  run_programs(
      programs_, [&](int i) { return leaves[static_cast<std::size_t>(i)]; }, not_of, and_of, or_of,
      result);
  Possible out;
  for (std::size_t j = 0; j < size(); ++j) {
    if (result[j] == Truth::kTrue) out.sure |= 1U << j;
    if (result[j] == Truth::kUnknown) out.open |= 1U << j;
  }
  out.importance = greatest_mean(out.sure, out.open);
  return out;
}

// Adding an impact raises a mean while the impact exceeds the mean. So the open entries are added
// in the order of their impact.
double PredicateSet::greatest_mean(std::uint32_t sure, std::uint32_t open) const {
  double sum = 0;
  int count = 0;
  for (std::size_t j = 0; j < size(); ++j) {
    if (((sure >> j) & 1U) == 0) continue;
    sum += weights_[j].impact;
    ++count;
  }
  for (const int j : by_impact_) {
    const double impact = weights_[static_cast<std::size_t>(j)].impact;
    if (((open >> j) & 1U) == 0) continue;
    if (count > 0 && impact * count <= sum) break;
    sum += impact;
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace nav::render
