// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_predicates.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "nav/index.hpp"
#include "render/cpu/cpu_inputs.hpp"
#include "render/cpu/predicate_atoms.hpp"
#include "render/cpu/predicate_early_ends.hpp"
#include "render/predicates/set.hpp"
#include "render/spec/ray_spec.hpp"
#include "render/surfaces.hpp"

namespace nav::render {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

bool same_appearance(const PredicateAppearance& a, const PredicateAppearance& b) {
  if (!(a.importance > 0) && !(b.importance > 0)) return true;
  return a.importance == b.importance && std::equal(a.tint, a.tint + 3, b.tint);
}

/// Number of eights in a column that holds a number of appearances.
std::size_t eights_of(std::size_t appearances) { return std::bit_ceil((appearances + 7) / 8); }

/// Bits b that are set for either value of leaf j.
std::uint64_t with_either(std::uint64_t bits, std::size_t j) {
  constexpr std::uint64_t kFalse[] = {0x5555555555555555U, 0x3333333333333333U,
                                      0x0f0f0f0f0f0f0f0fU, 0x00ff00ff00ff00ffU,
                                      0x0000ffff0000ffffU, 0x00000000ffffffffU};
  const std::uint64_t shift = std::uint64_t{1} << j;
  return bits | (bits >> shift & kFalse[j]) | (bits & kFalse[j]) << shift;
}

}  // namespace

static_assert(kMarchFullImportance == kFullImportance);

void CpuPredicates::update(const Scene& scene, int threads, std::optional<double> beside) {
  auto set = *PredicateSet::create(*scene.predicates, scene.ct, position_of(scene));
  set_ = std::move(set);
  const bool alike = set_->uniform() && (!beside || *beside >= set_->greatest_impact());
  blend_ = alike                                               ? PredicateBlend::kOver
           : spec::weights_suffice(0, set_->greatest_impact()) ? PredicateBlend::kWeight
                                                               : PredicateBlend::kLog;
  if (known_.update(*set_, threads)) {
    take_channels(threads);
    make_atoms();
  }
  make_appearances();
  make_bricks(threads);
  make_opacities(scene);
  take_gradients(scene, threads);
}

std::size_t CpuPredicates::missing_bytes(const PredicateSet& set) const {
  const auto copies = std::count_if(set.channels().begin(), set.channels().end(),
                                    [&](const auto& channel) { return !has(channel.codes.get()); });
  const std::size_t volume = set.channels()[0].codes->grid().voxel_count() * sizeof(std::int16_t);
  return (static_cast<std::size_t>(copies) + known_.missing_channels(set)) * volume;
}

void CpuPredicates::prepare_some(const PredicateSet& set, std::size_t bytes, int threads) {
  const std::size_t volume = set.channels()[0].codes->grid().voxel_count() * sizeof(std::int16_t);
  std::size_t done = 0;
  for (const auto& channel : set.channels()) {
    if (done >= bytes) return;
    if (has(channel.codes.get())) continue;
    prepare(channel, threads, prepared_);
    done += volume;
  }
  while (done < bytes && known_.prepare_channel(set, threads)) done += volume;
}

void CpuPredicates::prepare(const PredicateSet::Channel& channel, int threads,
                            std::map<const StoredVolume*, Prepared>& into) {
  auto volume = std::make_unique<CpuVolume>(*channel.codes, threads);
  into.emplace(channel.codes.get(), Prepared{channel.codes, std::move(volume)});
}

void CpuPredicates::make_opacities(const Scene& scene) {
  const IntensityOpacity extinction(scene.predicates->opacity_length_mm);
  const std::span<const float> tau = extinction.entries();
  tau_.resize(2 * tau.size());
  for (std::size_t i = 0; i < tau.size(); ++i) {
    tau_[2 * i] = tau[i];
    tau_[2 * i + 1] = tau[std::min(i + 1, tau.size() - 1)] - tau[i];
  }
  opacity_ = opacity_pieces(extinction, spec::step_mm(scene.quality, scene.ct->grid()));
}

void CpuPredicates::take_channels(int threads) {
  std::map<const StoredVolume*, Prepared> kept;
  for (const auto& channel : set_->channels()) {
    const StoredVolume* key = channel.codes.get();
    if (kept.count(key) != 0) continue;
    if (auto before = prepared_.extract(key); !before.empty()) {
      kept.insert(std::move(before));
      continue;
    }
    prepare(channel, threads, kept);
  }
  prepared_ = std::move(kept);
}

void CpuPredicates::take_gradients(const Scene& scene, int threads) {
  const auto& shading = scene.predicates->shading;
  if (!shading) {
    gradients_ = {};
  } else if (gradients_.codes != shading->source) {
    gradients_ = {shading->source, std::make_unique<CpuVolume>(*shading->source, threads)};
  }
}

void CpuPredicates::make_atoms() {
  atoms_.clear();
  for (const PredicateSet::Leaf& leaf : set_->leaves()) atoms_.push_back(atom_of(*set_, leaf));
}

float CpuPredicates::measure(double importance) const {
  if (blend_ != PredicateBlend::kWeight) return static_cast<float>(importance);
  return static_cast<float>(std::exp(importance - set_->greatest_impact()));
}

PredicateAppearance CpuPredicates::appearance_of(std::uint32_t leaves) const {
  const spec::PredicateClass c = set_->class_of(set_->mask_of(leaves));
  if (!(c.importance > 0)) return {{0, 0, 0}, 0};
  const Eigen::Vector3f tint = spec::hsl_tint(c.hue_deg, c.saturation).cast<float>();
  return {{tint.x(), tint.y(), tint.z()}, measure(c.importance)};
}

void CpuPredicates::make_appearances() {
  static std::atomic<std::uint64_t> generations{0};
  generation_ = ++generations;
  appearances_.clear();
  few_appearances_.clear();
  appearance_numbers_.clear();
  numbered_appearances_.clear();
  matters_.clear();
  if (atoms_.size() > kMostTabulated) return;
  for (std::uint32_t bits = 0; bits < (1U << atoms_.size()); ++bits)
    appearances_.push_back(appearance_of(bits));
  make_few_appearances();
  make_matters();
}

void CpuPredicates::make_matters() {
  const std::size_t n = atoms_.size();
  if (n > static_cast<std::size_t>(kWeighedLeaves)) return;
  const std::size_t count = std::size_t{1} << n;
  matters_.resize(count * n);
  for (std::size_t i = 0; i < n; ++i) {
    std::uint64_t decides = 0;  // Bit b: with the leaves as in b, leaf i changes the appearance.
    for (std::size_t b = 0; b < count; ++b) {
      if (!same_appearance(appearances_[b], appearances_[b ^ (std::size_t{1} << i)]))
        decides |= std::uint64_t{1} << b;
    }
    for (std::size_t known = 0; known < count; ++known) {
      std::uint64_t where = decides;
      for (std::size_t j = 0; j < n; ++j) {
        if ((known >> j & 1U) == 0) where = with_either(where, j);
      }
      matters_[n * known + i] = where;
    }
  }
}

/// Makes PredicateInputs::few_appearances.
std::vector<CpuPredicates::Eight> CpuPredicates::columns_of(
    const std::vector<PredicateAppearance>& appearances) {
  const std::size_t eights = eights_of(appearances.size());
  std::vector<Eight> out(4 * eights);
  const auto put = [&](std::size_t column, std::size_t at, float value) {
    out[column * eights + at / 8].of[at % 8] = value;
  };
  for (std::size_t at = 0; at < appearances.size(); ++at) {
    for (std::size_t c = 0; c < 3; ++c) put(c, at, appearances[at].tint[c]);
    put(3, at, appearances[at].importance);
  }
  return out;
}

void CpuPredicates::make_few_appearances() {
  std::vector<PredicateAppearance> different;
  std::vector<std::int32_t> numbers;
  for (const PredicateAppearance& appearance : appearances_) {
    const auto same = std::ranges::find_if(different, [&](const PredicateAppearance& other) {
      return same_appearance(appearance, other);
    });
    numbers.push_back(static_cast<std::int32_t>(same - different.begin()));
    if (same == different.end()) different.push_back(appearance);
    if (different.size() > static_cast<std::size_t>(kFewAppearances)) return;
  }
  if (appearances_.size() <= static_cast<std::size_t>(kFewAppearances)) {
    few_appearances_ = columns_of(appearances_);
  } else {
    few_appearances_ = columns_of(different);
    appearance_numbers_ = numbers;
  }
  const bool shorter = eights_of(different.size()) < eights_of(appearances_.size());
  if (!shorter || appearances_.size() > std::size_t{1} << kWeighedLeaves ||
      different.size() > static_cast<std::size_t>(kAppearancesOfNibbles))
    return;
  constexpr std::size_t kNibblesAWord = 8;
  numbered_appearances_ = columns_of(different);
  appearance_nibbles_ = {};
  for (std::size_t b = 0; b < numbers.size(); ++b) {
    const auto nibble = static_cast<std::uint32_t>(numbers[b]) << (4 * (b % kNibblesAWord));
    appearance_nibbles_.of[b / kNibblesAWord] |= static_cast<std::int32_t>(nibble);
  }
}

// Each thread keeps its last results, because neighbours have the same appearance.
void CpuPredicates::find_appearance(const void* self, std::uint32_t leaves,
                                    PredicateAppearance* out) {
  struct Kept {
    std::uint64_t generation = 0;
    std::uint32_t leaves = 0;
    PredicateAppearance appearance{};
  };
  constexpr std::size_t kSlots = 4096;
  thread_local std::array<Kept, kSlots> slots;
  const auto& predicates = *static_cast<const CpuPredicates*>(self);
  Kept& slot = slots[(leaves * 0x9E3779B1U) >> 20];
  if (slot.generation != predicates.generation_ || slot.leaves != leaves) {
    slot = {predicates.generation_, leaves, predicates.appearance_of(leaves)};
  }
  *out = slot.appearance;
}

void CpuPredicates::make_bricks(int threads) {
  const std::vector<double> exact = brick_importances(*set_, known_.leaves(), threads);
  constexpr double kRounding = 1 + 1e-5;
  importance_.resize(exact.size());
  std::vector<std::uint8_t> visible(exact.size());
  occupied_ = 0;
  for (std::size_t b = 0; b < exact.size(); ++b) {
    const bool some = exact[b] > 0;
    importance_[b] =
        some ? static_cast<float>(static_cast<double>(measure(exact[b])) * kRounding) : 0;
    visible[b] = some ? 1 : 0;
    occupied_ += some ? 1 : 0;
  }
  const BrickGrid& grid = known_.grid();
  // Distances of invisible bricks from the visible ones, and of visible bricks from the invisible
  // ones.
  const std::vector<std::uint8_t> distances = brick_depths(grid, visible);
  for (std::uint8_t& d : visible) d = d == 0 ? 1 : 0;
  const std::vector<std::uint8_t> depths = brick_depths(grid, visible);
  leaps_.assign(distances.size() + kBrickTail, 0);
  for (std::size_t b = 0; b < distances.size(); ++b) {
    const int distance = std::min<int>(distances[b], 127);
    leaps_[b] =
        static_cast<std::int8_t>(distance > 0 ? distance : 1 - std::min<int>(depths[b], 127));
  }
}

void CpuPredicates::set_grid(const Scene& scene, PredicateInputs& in) const {
  const VoxelGrid& grid = scene.ct->grid();
  const Prepared& ct = prepared_.at(scene.ct.get());
  const double step = spec::step_mm(scene.quality, grid);
  MarchInputs& base = in.base;
  base.row_stride = ct.volume->row_stride();
  base.slice_stride = ct.volume->slice_stride();
  base.step_mm = static_cast<float>(step);
  base.prefetch = march_prefetch(grid, scene.quality);
  base.opaque_at = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    base.last[axis] = static_cast<float>(grid.size[as_size(axis)] - 1);
    in.spacing_mm[axis] = static_cast<float>(grid.spacing_mm[axis]);
  }
  std::copy_n(known_.grid().count.data(), 3, base.bricks);
  in.brick_importance = importance_.data();
  if (scene.quality.skip_empty_bricks) {
    base.brick_leap = leaps_.data();
    base.cells_per_test = cells_per_test_in_runs(scene.quality);
    // A test of the volume's own value costs less than looking up whether it is needed.
    const bool costly = std::any_of(atoms_.begin(), atoms_.end(), [](const PredicateAtom& atom) {
      return atom.kind != PredicateAtom::kRange || atom.channel[0] != 0;
    });
    if (costly) {
      in.brick_sure = known_.leaves().sure.data();
      in.brick_open = known_.leaves().open.data();
    }
  }
  if (scene.cutaway) {
    constexpr double kFar = 1e30;
    const double overlay = scene.cutaway->overlay_mm / step;
    set_thresholds(*scene.cutaway, base);
    base.overlay_cells = static_cast<float>(std::min(overlay, kFar));
    base.per_overlay = static_cast<float>(std::min(1 / overlay, kFar));
  }
}

void CpuPredicates::set_opacity(const Scene& scene, PredicateInputs& in) const {
  const PredicateScene& predicates = *scene.predicates;
  const PredicateSet::Channel& volume = set_->channels()[0];
  in.intensity_offset = static_cast<float>(volume.offset);
  in.intensity_scale = static_cast<float>(volume.scale);
  in.last_entry = static_cast<float>(PredicateScene::kTauEntries - 1);
  in.tau = tau_.data();
  in.opacity = opacity_ ? opacity_->of[0] : nullptr;
  in.white_opacity = opacity_ ? opacity_->white : 0;
  const double greatest = std::max(set_->greatest_impact(), 1e-30);
  in.cutaway_scale = static_cast<float>(predicates.cutaway_importance / greatest);
  in.cutaway_greatest = static_cast<float>(greatest);
  in.leave_out_from = in.end_at = kInfinity;
  if (!(predicates.termination_error > 0)) return;
  const auto budget =
      spec::early_ends<float>(predicates.termination_error, !Surfaces(scene).empty());
  in.leave_out_from = budget.leave_out_from;
  in.leave_out_for = budget.leave_out_for;
  // Plain over never brings back hidden samples.
  in.end_at = blend_ == PredicateBlend::kOver ? static_cast<float>(1 - predicates.termination_error)
                                              : budget.end_at;
}

void CpuPredicates::set_shading(const Scene& scene, PredicateInputs& in) const {
  const auto& shading = scene.predicates->shading;
  if (!shading) return;
  const VoxelGrid& grid = scene.ct->grid();
  const double step = spec::step_mm(scene.quality, grid);
  in.base.gradient_voxels = gradients_.volume->origin();
  for (int axis = 0; axis < 3; ++axis) {
    in.base.half_per_spacing[axis] = static_cast<float>(0.5 / grid.spacing_mm[axis]);
    in.base.mm_per_index_step[axis] = static_cast<float>(grid.spacing_mm[axis] / step);
  }
  set_light(phong_of(*shading), in.base);
}

PredicateInputs CpuPredicates::inputs(const Scene& scene) const {
  PredicateInputs in{};
  set_grid(scene, in);
  set_opacity(scene, in);
  set_shading(scene, in);
  for (std::size_t i = 0; i < set_->channels().size(); ++i) {
    const PredicateSet::Channel& channel = set_->channels()[i];
    in.codes[i] = prepared_.at(channel.codes.get()).volume->origin();
    in.has_undefined[i] = channel.has_undefined;
  }
  if (set_->labels()) {
    const auto& size = scene.ct->grid().size;
    in.labels = set_->labels()->bits().data();
    in.label_row = size[0];
    in.label_slice = size[0] * size[1];
  }
  in.atoms = atoms_.data();
  in.all_leaves = atoms_.size() < 32 ? (1U << atoms_.size()) - 1U : ~0U;
  in.leaf_count = static_cast<int>(atoms_.size());
  std::iota(in.order, in.order + in.leaf_count, 0);
  std::stable_sort(in.order, in.order + in.leaf_count, [&](int a, int b) {
    return rank_of_test(atoms_[as_size(a)]) < rank_of_test(atoms_[as_size(b)]);
  });
  in.cheap_leaves =
      static_cast<int>(std::count_if(atoms_.begin(), atoms_.end(), [](const PredicateAtom& atom) {
        return rank_of_test(atom) == 0;
      }));
  in.matters = matters_.empty() ? nullptr : matters_.data();
  in.appearances = appearances_.empty() ? nullptr : appearances_.data();
  in.find_appearance = &CpuPredicates::find_appearance;
  in.appearance_finder = this;
  in.few_appearances = few_appearances_.empty() ? nullptr : few_appearances_.front().of;
  in.few_eights = static_cast<int>(few_appearances_.size() / 4);
  in.appearance_numbers = appearance_numbers_.empty() ? nullptr : appearance_numbers_.data();
  in.appearance_nibbles = numbered_appearances_.empty() ? nullptr : appearance_nibbles_.of;
  in.numbered_appearances =
      numbered_appearances_.empty() ? nullptr : numbered_appearances_.front().of;
  in.numbered_eights = static_cast<int>(numbered_appearances_.size() / 4);
  return in;
}

}  // namespace nav::render
