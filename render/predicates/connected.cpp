// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/connected.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "nav/check.hpp"
#include "render/parallel.hpp"
#include "render/predicates/predicate_sampler.hpp"
#include "render/transfer/enclosed.hpp"

namespace nav::render {
namespace {

using Operator = PredicateExpression::Operator;
constexpr const char* kLabelKind = "label";

bool contains_connected(const PredicateExpression& e) {
  return e.op == Operator::kConnected || std::ranges::any_of(e.operands, contains_connected);
}

/// Bits of the label predicates of an expression.
std::uint32_t bits_asked(const PredicateExpression& e) {
  std::uint32_t bits = 0;
  if (e.op == Operator::kKind && e.name == kLabelKind) {
    bits = e.values.empty() ? 1U : static_cast<std::uint32_t>(e.values[0]);
  }
  for (const auto& operand : e.operands) bits |= bits_asked(operand);
  return bits;
}

/// Marks a part of voxels and those around it, edges and corners included.
void mark_around(const VoxelLattice& lattice, const std::vector<std::uint32_t>& part,
                 std::vector<std::uint8_t>& marks) {
  const auto size = [&](int axis) { return static_cast<std::ptrdiff_t>(lattice.size(axis)); };
  for (const std::uint32_t i : part) {
    const std::ptrdiff_t x = i % size(0);
    const std::ptrdiff_t y = i / size(0) % size(1);
    const std::ptrdiff_t z = i / (size(0) * size(1));
    for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(z - 1, 0); k <= std::min(z + 1, size(2) - 1);
         ++k) {
      for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(y - 1, 0); j <= std::min(y + 1, size(1) - 1);
           ++j) {
        for (std::ptrdiff_t n = std::max<std::ptrdiff_t>(x - 1, 0);
             n <= std::min(x + 1, size(0) - 1); ++n) {
          marks[static_cast<std::size_t>((k * size(1) + j) * size(0) + n)] = 1;
        }
      }
    }
  }
}

/// Resolves the `connected` of one model.
class ConnectedResolver {
 public:
  explicit ConnectedResolver(PredicateVolume& volume) : volume_(volume) {
    const auto& labels = volume.predicates.features.labels;
    const std::size_t voxels = volume.ultrasound->grid().voxel_count();
    if (labels) {
      bits_.assign(labels->bits().begin(), labels->bits().end());
    } else {
      bits_.assign(voxels, 0);
    }
    for (const std::uint32_t bits : bits_) used_ |= bits;
    for (const auto& entry : volume.predicates.model.entries) used_ |= bits_asked(entry.expression);
  }

  Result<void> run() {
    auto& model = volume_.predicates.model;
    for (PredicateEntry& entry : model.entries) {
      auto resolved = resolve(entry.name, entry.expression);
      if (!resolved) return resolved.error();
      entry.expression = *std::move(resolved);
    }
    auto labels = LabelVolume::create(volume_.ultrasound->grid(), std::move(bits_), "labels");
    if (!labels) return labels.error();
    volume_.predicates.features.labels = *std::move(labels);
    return {};
  }

 private:
  Result<PredicateExpression> resolve(const std::string& entry, const PredicateExpression& e) {
    PredicateExpression out = e;
    for (auto& operand : out.operands) {
      auto resolved = resolve(entry, operand);
      if (!resolved) return resolved;
      operand = *std::move(resolved);
    }
    if (e.op != Operator::kConnected) return out;
    const auto bit = bit_of(entry, out.operands.front(), e.values.front());
    if (!bit) return bit.error();
    const auto label = PredicateExpression::kind(kLabelKind, {static_cast<double>(*bit)});
    return PredicateExpression::all({std::move(out.operands.front()), label});
  }

  Result<std::uint32_t> bit_of(const std::string& entry, const PredicateExpression& operand,
                               double least_mm3) {
    // References to entries that come later may hold further ones.
    PredicateExpression inlined = without_references(volume_.predicates.model, operand);
    if (contains_connected(inlined)) {
      auto inner = resolve(entry, inlined);
      if (!inner) return inner.error();
      inlined = *std::move(inner);
    }
    if (reads_distances(inlined)) {
      return Error{ErrorCode::kUsage, entry + ": connected: expected predicates of the volume, " +
                                          "found a distance from the needle or the target"};
    }
    for (const auto& [known, least, bit] : done_) {
      if (known == inlined && least == least_mm3) return bit;
    }
    const std::uint32_t free = ~used_;
    if (free == 0) {
      return Error{ErrorCode::kUsage,
                   entry + ": connected: expected a free bit of the labels, found all 32 in use"};
    }
    const std::uint32_t bit = free & (~free + 1);
    used_ |= bit;
    const auto marks = large_parts(inlined, least_mm3);
    if (!marks) return marks.error();
    for (std::size_t i = 0; i < bits_.size(); ++i) {
      if ((*marks)[i] != 0) bits_[i] |= bit;
    }
    done_.push_back({inlined, least_mm3, bit});
    return bit;
  }

  Result<std::vector<std::uint8_t>> large_parts(const PredicateExpression& e, double least_mm3) {
    const VoxelGrid& grid = volume_.ultrasound->grid();
    PredicateScene scene = volume_.predicates;
    scene.model.entries = {{"connected", e}};
    scene.model.histogram = *PredicateHistogram::create({{1, 0, 0}});
    auto labels = LabelVolume::create(grid, bits_, "labels");
    if (!labels) return labels.error();
    scene.features.labels = *std::move(labels);
    const auto set =
        PredicateSet::create(scene, volume_.ultrasound, {grid, volume_.predicates.scan, {}, {}});
    if (!set) return set.error();
    const PredicateSampler sampler(*set);
    std::vector<std::uint8_t> is_true(grid.voxel_count());
    for_each_index(grid.size[2], 0, [&](int k) {
      std::size_t at = static_cast<std::size_t>(k) * static_cast<std::size_t>(grid.size[0]) *
                       static_cast<std::size_t>(grid.size[1]);
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i, ++at) {
          is_true[at] = static_cast<std::uint8_t>(sampler.mask({1.0 * i, 1.0 * j, 1.0 * k}) & 1U);
        }
      }
    });
    const VoxelLattice lattice(grid);
    const double voxel_mm3 = grid.spacing_mm.prod();
    std::vector<std::uint8_t> marks(is_true.size(), 0);
    std::vector<std::uint32_t> small;
    for (const auto& part : components_of(lattice, is_true)) {
      if (static_cast<double>(part.size()) * voxel_mm3 >= least_mm3) {
        mark_around(lattice, part, marks);
      } else {
        small.insert(small.end(), part.begin(), part.end());
      }
    }
    for (const std::uint32_t i : small) marks[i] = 0;
    return marks;
  }

  struct Done {
    PredicateExpression operand;
    double least_mm3;
    std::uint32_t bit;
  };
  PredicateVolume& volume_;
  std::vector<std::uint32_t> bits_;
  std::uint32_t used_ = 0;
  std::vector<Done> done_;
};

}  // namespace

PredicateExpression without_references(const PredicateModel& model, const PredicateExpression& e) {
  if (e.op == Operator::kEntry) {
    const auto found = std::ranges::find(model.entries, e.name, &PredicateEntry::name);
    NAV_CHECK(found != model.entries.end(), e.name);
    return without_references(model, found->expression);
  }
  PredicateExpression out = e;
  for (auto& operand : out.operands) operand = without_references(model, operand);
  return out;
}

bool reads_distances(const PredicateExpression& e) {
  if (e.op == Operator::kKind && (e.name == "needle_distance" || e.name == "target_distance")) {
    return true;
  }
  return std::ranges::any_of(e.operands, reads_distances);
}

bool has_connected(const PredicateModel& model) {
  return std::ranges::any_of(model.entries, contains_connected, &PredicateEntry::expression);
}

Result<void> resolve_connected(PredicateVolume& volume) {
  if (!has_connected(volume.predicates.model)) return {};
  if (const auto ok = validate(volume.predicates.model); !ok) return ok;
  const auto& labels = volume.predicates.features.labels;
  if (labels && labels->layers()) {
    return Error{ErrorCode::kUsage,
                 "connected: expected labels of voxels or none, found surfaces (--layers)"};
  }
  return ConnectedResolver(volume).run();
}

}  // namespace nav::render
