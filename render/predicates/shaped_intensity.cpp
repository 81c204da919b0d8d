// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/shaped_intensity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <vector>

#include "nav/check.hpp"
#include "render/parallel.hpp"
#include "render/predicates/connected.hpp"
#include "render/predicates/predicate_sampler.hpp"
#include "render/predicates/registry.hpp"

namespace nav::render {
namespace {

using Operator = PredicateExpression::Operator;

/// Parameters of a kind of predicate, also where an expression leaves them out.
std::vector<double> values_of(const PredicateKind& kind, const PredicateExpression& e) {
  if (!e.values.empty()) return e.values;
  std::vector<double> values;
  for (const auto& parameter : kind.parameters()) values.push_back(parameter.initial);
  return values;
}

/// The kind of an expression if it is a range of one feature, otherwise null.
const PredicateKind* range_kind(const PredicateExpression& e) {
  if (e.op != Operator::kKind) return nullptr;
  const auto kind = find_predicate_kind(e.name);
  NAV_CHECK(kind.has_value(), e.name);
  return dynamic_cast<const RangePredicate*>(*kind);
}

/// Ranges widened by their ramps. \p positive: not under an odd number of `not`.
PredicateExpression widened(const PredicateExpression& e, double share, bool positive) {
  PredicateExpression out = e;
  for (auto& operand : out.operands) {
    operand = widened(operand, share, positive != (e.op == Operator::kNot));
  }
  const PredicateKind* kind = range_kind(e);
  if (kind == nullptr || !positive) return out;
  const auto parameters = kind->parameters();
  out.values = values_of(*kind, e);
  out.values[0] = std::max(out.values[0] - share * std::abs(out.values[0]), parameters[0].low);
  out.values[1] = std::min(out.values[1] + share * std::abs(out.values[1]), parameters[1].high);
  return out;
}

double ramp_of(double inside, double width) {
  if (!(width > 0)) return inside >= 0 ? 1 : 0;
  return std::clamp((inside + width) / width, 0.0, 1.0);
}

/// Soft truth of expressions without references, at voxels.
class SoftTruth {
 public:
  SoftTruth(const PredicateSet& set, double share) : set_(set), sampler_(set), share_(share) {}

  [[nodiscard]] double of(const PredicateExpression& e, const Eigen::Vector3d& voxel,
                          std::uint32_t leaves) const {
    switch (e.op) {
      case Operator::kKind:
        return of_kind(e, voxel, leaves);
      case Operator::kNot:
        return 1 - of(e.operands.front(), voxel, leaves);
      case Operator::kAnd: {
        double least = 1;
        for (const auto& one : e.operands) least = std::min(least, of(one, voxel, leaves));
        return least;
      }
      case Operator::kOr: {
        double most = 0;
        for (const auto& one : e.operands) most = std::max(most, of(one, voxel, leaves));
        return most;
      }
      case Operator::kEntry:
      case Operator::kConnected:
        break;
    }
    NAV_CHECK(false, "references and connected parts are resolved");
    return 0;
  }

 private:
  [[nodiscard]] double of_kind(const PredicateExpression& e, const Eigen::Vector3d& voxel,
                               std::uint32_t leaves) const {
    const PredicateKind* kind = *find_predicate_kind(e.name);
    const std::vector<double> values = values_of(*kind, e);
    for (std::size_t n = 0; n < set_.leaves().size(); ++n) {
      const PredicateSet::Leaf& leaf = set_.leaves()[n];
      if (leaf.kind != kind || leaf.values != values) continue;
      if (dynamic_cast<const RangePredicate*>(kind) == nullptr) return (leaves >> n & 1U) != 0;
      const double v = sampler_.value(static_cast<std::size_t>(leaf.channels.front()), voxel);
      if (std::isnan(v)) return 0;
      return std::min(ramp_of(v - values[0], share_ * std::abs(values[0])),
                      ramp_of(values[1] - v, share_ * std::abs(values[1])));
    }
    NAV_CHECK(false, e.name);
    return 0;
  }

  const PredicateSet& set_;
  PredicateSampler sampler_;
  double share_;
};

/// The stored values as a feature.
Result<FeatureVolume> intensity_feature(const StoredVolume& volume,
                                        const PredicateScene::IntensityWindow& window) {
  std::vector<float> shares(volume.values().size());
  std::ranges::transform(volume.values(), shares.begin(), [&](std::int16_t v) {
    return static_cast<float>((v - window.black) / (window.white - window.black));
  });
  return FeatureVolume::create(volume.grid(), shares, feature::kIntensity);
}

}  // namespace

Result<void> shape_intensity(PredicateVolume& volume, double soft_share) {
  if (!(soft_share >= 0 && soft_share <= 1)) {
    std::ostringstream text;
    text << "soft thresholds: expected a share in [0, 1], found " << soft_share;
    return Error{ErrorCode::kUsage, text.str()};
  }
  PredicateModel& model = volume.predicates.model;
  const auto& bars = model.histogram.bars();
  const bool floors =
      std::ranges::any_of(model.entries, [](const auto& entry) { return entry.floor > 0; });
  if (!floors && soft_share == 0) return {};
  if (const auto ok = validate(model); !ok) return ok;

  PredicateModel plain;  // Without references, and only with entries that shape.
  std::vector<PredicateHistogram::Bar> plain_bars;
  std::vector<double> floor_of;
  for (std::size_t j = 0; j < model.entries.size(); ++j) {
    const PredicateEntry& entry = model.entries[j];
    if (!(bars[j].importance > 0) || (soft_share == 0 && entry.floor == 0)) continue;
    plain.entries.push_back({entry.name, without_references(model, entry.expression)});
    plain_bars.push_back(bars[j]);
    floor_of.push_back(entry.floor);
    if (reads_distances(plain.entries.back().expression)) {
      return Error{ErrorCode::kUsage, entry.name +
                                          ": floors and soft thresholds: expected predicates of "
                                          "the volume, found a distance from the needle or the "
                                          "target"};
    }
  }
  if (plain.entries.empty()) return {};
  auto histogram = PredicateHistogram::create(std::move(plain_bars));
  if (!histogram) return histogram.error();
  plain.histogram = *std::move(histogram);

  PredicateScene scene = volume.predicates;
  scene.model = plain;
  const auto& ultrasound = volume.ultrasound;
  const VoxelGrid& grid = ultrasound->grid();
  const auto set = PredicateSet::create(scene, ultrasound, {grid, scene.scan, {}, {}});
  if (!set) return set.error();
  auto original = intensity_feature(*ultrasound, scene.intensity);
  if (!original) return original.error();

  const SoftTruth soft(*set, soft_share);
  const PredicateSampler sampler(*set);
  const double black = scene.intensity.black;
  const double width = scene.intensity.white - black;
  using Stored = std::numeric_limits<std::int16_t>;
  std::vector<std::int16_t> values(ultrasound->values().begin(), ultrasound->values().end());
  for_each_index(grid.size[2], 0, [&](int k) {
    std::size_t at = static_cast<std::size_t>(k) * static_cast<std::size_t>(grid.size[0]) *
                     static_cast<std::size_t>(grid.size[1]);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++at) {
        const Eigen::Vector3d voxel(i, j, k);
        const std::uint32_t leaves = sampler.leaves(voxel);
        const std::uint32_t mask = set->mask_of(leaves);
        double share = (values[at] - black) / width;
        if (soft_share > 0) {
          double most = 0;
          for (const auto& entry : plain.entries) {
            most = std::max(most, soft.of(entry.expression, voxel, leaves));
          }
          // Voxels where nothing is true keep their value for the interpolation.
          if (most > 0 && most < 1) share *= most;
        }
        for (std::size_t n = 0; n < floor_of.size(); ++n) {
          if ((mask >> n & 1U) != 0) share = std::max(share, floor_of[n]);
        }
        values[at] = static_cast<std::int16_t>(
            std::clamp<double>(std::round(black + share * width), Stored::min(), Stored::max()));
      }
    }
  });
  auto shaped = StoredVolume::create(grid, std::move(values), ultrasound->name());
  if (!shaped) return shaped.error();
  volume.ultrasound = std::make_shared<const StoredVolume>(*std::move(shaped));
  volume.predicates.features.volumes.insert_or_assign(feature::kIntensity, *std::move(original));
  if (soft_share > 0) {
    const PredicateModel before = model;
    for (PredicateEntry& entry : model.entries) {
      entry.expression = widened(without_references(before, entry.expression), soft_share, true);
    }
  }
  return {};
}

}  // namespace nav::render
