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

/// Data that the CPU engine keeps between images by predicates. Volumes and their bricks stay while
/// they are used. A new parameter classifies bricks again; a new importance only weighs them again.
class CpuPredicates {
 public:
  /// Prepares for a validated scene with predicates whose volume fits. \p beside: impact of the
  /// other samples that are composited with it, except surfaces.
  void update(const Scene& scene, int threads, std::optional<double> beside = {});
  /// True when the voxels of a volume are ready.
  [[nodiscard]] bool has(const StoredVolume* codes) const { return prepared_.count(codes) != 0; }
  /// Approximate number of bytes that update() would have to copy or to read for a set.
  [[nodiscard]] std::size_t missing_bytes(const PredicateSet& set) const;
  /// Does about this many bytes of that work, > 0. An image needs update() in any case.
  void prepare_some(const PredicateSet& set, std::size_t bytes, int threads);

  [[nodiscard]] const PredicateSet& set() const { return *set_; }
  [[nodiscard]] PredicateBlend blend() const { return blend_; }
  /// Inputs for the scene of the last update(); valid until the next update().
  [[nodiscard]] PredicateInputs inputs(const Scene& scene) const;
  /// Importance of surfaces, in the units of PredicateAppearance.
  [[nodiscard]] float greatest() const { return measure(set_->greatest_impact()); }
  /// Importance of an impact, limited to the greatest, in the units of PredicateAppearance.
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
    std::shared_ptr<const StoredVolume> codes;  ///< Held so that no other volume gets its address.
    std::unique_ptr<CpuVolume> volume;
  };

  static void prepare(const PredicateSet::Channel& channel, int threads,
                      std::map<const StoredVolume*, Prepared>& into);
  void take_channels(int threads);
  void make_atoms();
  void make_appearances();
  void make_few_appearances();
  static std::vector<Eight> columns_of(const std::vector<PredicateAppearance>& appearances);
  void make_matters();
  void make_opacities(const Scene& scene);
  void make_bricks(int threads);
  void take_gradients(const Scene& scene, int threads);
  [[nodiscard]] float measure(double importance) const;
  [[nodiscard]] PredicateAppearance appearance_of(std::uint32_t leaves) const;
  static void find_appearance(const void* self, std::uint32_t leaves, PredicateAppearance* out);
  void set_grid(const Scene& scene, PredicateInputs& in) const;
  void set_opacity(const Scene& scene, PredicateInputs& in) const;
  void set_shading(const Scene& scene, PredicateInputs& in) const;

  std::optional<PredicateSet> set_;
  PredicateBlend blend_ = PredicateBlend::kOver;
  std::map<const StoredVolume*, Prepared> prepared_;
  Prepared gradients_{};  ///< Source of the shading; empty without shading.
  PredicateBrickCache known_;
  std::vector<float> importance_;
  std::vector<std::int8_t> leaps_;
  std::size_t occupied_ = 0;
  std::vector<PredicateAtom> atoms_;
  std::vector<PredicateAppearance> appearances_;
  std::vector<std::uint64_t> matters_;  ///< PredicateInputs::matters.
  std::vector<Eight> few_appearances_;  ///< PredicateInputs::few_appearances.
  std::vector<std::int32_t> appearance_numbers_;
  std::vector<Eight> numbered_appearances_;
  Nibbles appearance_nibbles_;
  std::vector<float> tau_;  ///< PredicateInputs::tau.
  std::optional<OpacityPieces> opacity_;
  std::uint64_t generation_ = 0;  ///< Version of the appearances that threads keep.
};

}  // namespace nav::render
