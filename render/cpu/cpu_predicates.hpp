// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "render/cpu/cpu_volume.hpp"
#include "render/cpu/opacity_pieces.hpp"
#include "render/cpu/predicate_march.hpp"
#include "render/predicates/predicate_sampler.hpp"
#include "render/predicates/set.hpp"
#include "render/scene.hpp"
#include "render/skipping/predicate_brick_cache.hpp"

namespace nav::render {

/// What the CPU engine keeps between pictures by predicates. Volumes and their bricks stay while
/// they are asked for; a new parameter classifies bricks anew, a new importance only weighs them.
class CpuPredicates {
 public:
  /// Prepares for a validated scene with predicates whose volume fits. beside: impact of what
  /// else is composited with it but for surfaces.
  void update(const Scene& scene, int threads, std::optional<double> beside = {});
  /// Voxels of that volume are ready.
  [[nodiscard]] bool has(const Volume* codes) const { return prepared_.count(codes) != 0; }
  /// About how many bytes update() would have to copy or to look through for that set.
  [[nodiscard]] std::size_t missing_bytes(const PredicateSet& set) const;
  /// Does about so much of that, > 0. A picture needs update() all the same.
  void prepare_some(const PredicateSet& set, std::size_t bytes, int threads);

  [[nodiscard]] const PredicateSet& set() const { return *set_; }
  [[nodiscard]] PredicateBlend blend() const { return blend_; }
  /// For the scene of the last update(); valid until the next one.
  [[nodiscard]] PredicateInputs inputs(const Scene& scene) const;
  /// In the measure of PredicateLook: of surfaces.
  [[nodiscard]] float greatest() const { return measure(set_->greatest_impact()); }
  /// In the measure of PredicateLook: of an impact, held at the greatest.
  [[nodiscard]] float of_impact(double impact) const {
    return measure(std::min(impact, set_->greatest_impact()));
  }
  [[nodiscard]] float initial() const { return blend_ == PredicateBlend::kLog ? 0 : measure(0); }
  [[nodiscard]] std::size_t bricks() const { return importance_.size(); }
  [[nodiscard]] std::size_t bricks_occupied() const { return occupied_; }

 private:
  struct alignas(32) Eight {
    float of[8] = {};
  };
  struct alignas(32) Nibbles {
    std::int32_t of[8] = {};
  };
  struct Prepared {
    std::shared_ptr<const Volume> codes;  ///< Held, so that its address stays its own.
    std::unique_ptr<CpuVolume> volume;
  };

  static void prepare(const PredicateSet::Channel& channel, int threads,
                      std::map<const Volume*, Prepared>& into);
  void take_channels(int threads);
  void make_atoms();
  void make_looks();
  void make_few_looks();
  static std::vector<Eight> columns_of(const std::vector<PredicateLook>& looks);
  void make_matters();
  void make_opacities(const Scene& scene);
  void make_bricks(int threads);
  [[nodiscard]] float measure(double importance) const;
  [[nodiscard]] PredicateLook look_of(std::uint32_t leaves) const;
  static void find_look(const void* self, std::uint32_t leaves, PredicateLook* out);
  void set_grid(const Scene& scene, PredicateInputs& in) const;
  void set_opacity(const Scene& scene, PredicateInputs& in) const;

  std::optional<PredicateSet> set_;
  PredicateBlend blend_ = PredicateBlend::kOver;
  std::map<const Volume*, Prepared> prepared_;
  PredicateBrickCache known_;
  std::vector<float> importance_;
  std::vector<std::int8_t> leaps_;
  std::size_t occupied_ = 0;
  std::vector<PredicateAtom> atoms_;
  std::vector<PredicateLook> looks_;
  std::vector<std::uint64_t> matters_;  ///< PredicateInputs::matters.
  std::vector<Eight> few_looks_;        ///< PredicateInputs::few_looks.
  std::vector<std::int32_t> look_numbers_;
  std::vector<Eight> numbered_looks_;
  Nibbles look_nibbles_;
  std::vector<float> tau_;  ///< PredicateInputs::tau.
  std::optional<OpacityPieces> opacity_;
  std::uint64_t generation_ = 0;  ///< Of looks that threads keep.
};

}  // namespace nav::render
